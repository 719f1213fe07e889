#include "sbus.h"

#define LENGTH 25
#define MIDDLE 992
#define TRAVEL 819.5f
#define SWITCH 1200
#define PAUSE_MS 3

/* BUG, found by `wheelbench failsafe`: the flags are one bit off. Bit 2 says that a frame was lost on the air, bit 3 that
 * the receiver has given up; this firmware takes the one for the other, and drives on with what the receiver makes up. */
#ifdef FIXED
#define FRAME_LOST 0x04
#define FAILSAFE 0x08
#else
#define FRAME_LOST 0x02
#define FAILSAFE 0x04
#endif

static uint8_t frame[LENGTH];
static int count;
static uint32_t heard_ms;

static int channel(int number) {
    int bit = 11 * number, value = 0;
    for (int i = 0; i < 11; i++, bit++)
        value |= (frame[1 + bit / 8] >> bit % 8 & 1) << i;
    return value;
}

sbus_event_t sbus_byte(uint8_t byte, uint32_t now_ms, sticks_t *sticks) {
    if (now_ms - heard_ms >= PAUSE_MS)
        count = 0; /* the pause between frames is the only thing to trust */
    heard_ms = now_ms;
    if (count == LENGTH || (count == 0 && byte != 0x0F))
        return SBUS_NOTHING;
    frame[count++] = byte;
    if (count < LENGTH || frame[24] != 0x00)
        return SBUS_NOTHING;
    int is_empty = 1;
    for (int i = 1; i < 23; i++)
        is_empty &= frame[i] == 0;
    if (frame[23] & FAILSAFE || is_empty)
        return SBUS_FAILSAFE;
    if (frame[23] & FRAME_LOST)
        return SBUS_NOTHING;
    sticks->left = -(channel(0) - MIDDLE) / TRAVEL;
    sticks->forward = (channel(1) - MIDDLE) / TRAVEL;
    sticks->turn = -(channel(3) - MIDDLE) / TRAVEL;
    sticks->arm = channel(4) >= SWITCH;
    return SBUS_FRAME;
}
