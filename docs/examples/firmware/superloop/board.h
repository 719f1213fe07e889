/* What this firmware needs of its board. On the robot board.c has it; on the bench wheelbench_port.c. */
#ifndef BOARD_H
#define BOARD_H

#include <stdbool.h>
#include <stdint.h>

uint32_t board_ms(void);
bool board_rc_byte(uint8_t *byte);
bool board_core_byte(uint8_t *byte);
void board_core_send(const uint8_t *bytes, int count);
bool board_can_receive(uint16_t *id, uint8_t data[8]);
void board_can_send(uint16_t id, const uint8_t data[8]);

#endif
