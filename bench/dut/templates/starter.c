/* A firmware to begin with: one axis, no failsafe at all. `wheelbench failsafe` tells what it lacks. Written for the
 * default robot and its receiver, uart12.
 */
#include "wheelbench.h"

enum { LENGTH = 12, FULL_STICK_MA = 500 };

static uint8_t frame[LENGTH];
static int held, stick, armed, was_pressed;

static void rc_byte(uint8_t byte) {
    if (held == 0 && byte != 0xAA)
        return;
    frame[held++] = byte;
    if (held < LENGTH)
        return;
    held = 0;
    if (frame[11] != 0x55)
        return;
    stick = 2048 - (frame[5] << 8 | frame[6]); /* below the middle is forward */
    if (frame[9] && !was_pressed)
        armed = !armed;
    was_pressed = frame[9];
}

static void control(void) {
    static const int pattern[3] = {-1, 0, 1}; /* front right, rear, front left */
    uint8_t data[8] = {0};
    for (int i = 0; i < 3; i++) {
        int current_ma = armed ? pattern[i] * stick * FULL_STICK_MA / 2048 : 0;
        data[2 * i] = (uint8_t)(current_ma >> 8);
        data[2 * i + 1] = (uint8_t)current_ma;
    }
    wb_can_write(0x200, data, 8);
}

int main(void) {
    for (uint32_t done_ms = 0;;) {
        uint8_t byte;
        while (wb_uart_read(WB_RC, &byte, 1))
            rc_byte(byte);
        if (wb_millis() != done_ms) {
            done_ms++;
            control();
        }
    }
}
