/* SBUS: 25 bytes, 16 channels of 11 bits, a byte of flags. */
#ifndef SBUS_H
#define SBUS_H

#include "driver.h"

typedef enum { SBUS_NOTHING, SBUS_FRAME, SBUS_FAILSAFE } sbus_event_t;

sbus_event_t sbus_byte(uint8_t byte, uint32_t now_ms, sticks_t *sticks);

#endif
