#pragma once
#include <stdint.h>
#include <stdbool.h>
typedef struct { int16_t ch[4]; uint8_t sw[2]; uint32_t last_ms; } rc_t;
extern volatile rc_t rc;
void dbus_feed(const uint8_t *buf, uint16_t len);
typedef struct { uint16_t angle; int16_t rpm; int16_t current; uint32_t last_ms; } motor_t;
extern volatile motor_t motors[3];
void motors_start(void);
void motors_send(const int16_t ma[3]);
void drive_step(void);
