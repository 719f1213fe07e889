/* What your board's files do on the robot, on the bench. wheelbench.h tells what there is; time passes in its calls.
 *
 * These are examples: give them the names that your firmware calls, and their bodies the bench's wires.
 */
#include "wheelbench.h"

uint32_t millis(void) {
    return wb_millis();
}

int rc_uart_read(uint8_t *byte) {
    return wb_uart_read(WB_RC, byte, 1);
}

int slamware_uart_read(uint8_t *byte) {
    return wb_uart_read(WB_SLAMWARE, byte, 1);
}

void slamware_uart_write(const uint8_t *bytes, int count) {
    wb_uart_write(WB_SLAMWARE, bytes, count);
}

int can_receive(uint16_t *id, uint8_t data[8], uint8_t *length) {
    return wb_can_read(id, data, length);
}

int can_send(uint16_t id, const uint8_t *data, uint8_t length) {
    return wb_can_write(id, data, length);
}
