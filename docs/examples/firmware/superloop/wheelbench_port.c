/* The board's calls, on the bench. See wheelbench.h for what there is. */
#include "board.h"
#include "wheelbench.h"

uint32_t board_ms(void) {
    return wb_millis();
}

bool board_rc_byte(uint8_t *byte) {
    return wb_uart_read(WB_RC, byte, 1) == 1;
}

bool board_core_byte(uint8_t *byte) {
    return wb_uart_read(WB_SLAMWARE, byte, 1) == 1;
}

void board_core_send(const uint8_t *bytes, int count) {
    wb_uart_write(WB_SLAMWARE, bytes, count);
}

bool board_can_receive(uint16_t *id, uint8_t data[8]) {
    uint8_t length;
    return wb_can_read(id, data, &length) == 1;
}

void board_can_send(uint16_t id, const uint8_t data[8]) {
    wb_can_write(id, data, 8);
}
