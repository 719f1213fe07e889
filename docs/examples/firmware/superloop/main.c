/* A super-loop: everything is asked, nothing interrupts. RC is uart12, twelve bytes without a checksum. */
#include "board.h"
#include "driver.h"
#include "slamware.h"

#include <string.h>

#define LENGTH 12

/* BUG, found by `wheelbench failsafe`: milliseconds in eight bits. A silence of 500 ms is never seen, it wraps before;
 * every 256 ms the link looks alive again. */
#ifdef FIXED
typedef uint32_t age_t;
#else
typedef uint8_t age_t;
#endif

static uint8_t window[LENGTH];
static int held;
static uint32_t last_frame_ms;
static bool has_frame;

static uint16_t word(int at) {
    return (uint16_t)(window[at] << 8 | window[at + 1]);
}

static bool is_frame(void) {
    return held == LENGTH && window[0] == 0xAA && window[11] == 0x55 && (word(1) | word(3) | word(5) | word(7)) < 4096
        && (window[9] | window[10]) < 2;
}

static void rc_byte(uint8_t byte, uint32_t now_ms) {
    if (held == LENGTH) { /* no checksum: look for the frame at every byte */
        memmove(window, window + 1, LENGTH - 1);
        held--;
    }
    window[held++] = byte;
    if (!is_frame())
        return;
    held = 0;
    if (word(1) == 0 && word(3) == 0 && word(5) == 0 && word(7) == 0) {
        driver_failsafe();
        return;
    }
    sticks_t sticks = {
        .forward = (2048 - word(5)) / 2048.0f,
        .left = (word(7) - 2048) / 2048.0f,
        .turn = (2048 - word(1)) / 2048.0f,
        .arm = window[9] != 0,
    };
    driver_frame(&sticks, now_ms);
    last_frame_ms = now_ms;
    has_frame = true;
}

static void control(uint32_t now_ms) {
    uint8_t data[8];
    age_t silent_ms = (age_t)(now_ms - last_frame_ms);
    const twist_t *wanted = has_frame ? driver_step(silent_ms, now_ms) : 0;
    wheels_step(wanted, now_ms, data);
    board_can_send(0x200, data);
}

int main(void) {
    uint32_t done_ms = 0;
    for (;;) {
        uint32_t now_ms = board_ms();
        uint8_t byte, data[8], answer[64];
        uint16_t id;
        while (board_can_receive(&id, data))
            wheels_feedback(id, data, now_ms);
        while (board_rc_byte(&byte))
            rc_byte(byte, now_ms);
        while (board_core_byte(&byte)) {
            int size = slamware_byte(byte, now_ms, answer);
            if (size)
                board_core_send(answer, size);
        }
        if (now_ms != done_ms) {
            done_ms = now_ms;
            control(now_ms);
        }
    }
}
