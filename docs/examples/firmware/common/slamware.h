/* The base's side of the SLAMWARE control bus: connect, power, velocity with odometry. No hardware in here. */
#ifndef SLAMWARE_H
#define SLAMWARE_H

#include "wheels.h"

/* Take a byte of the core's; the number of bytes to answer with, most often 0. */
int slamware_byte(uint8_t byte, uint32_t now_ms, uint8_t answer[64]);

#endif
