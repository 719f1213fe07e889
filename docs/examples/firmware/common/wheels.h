/* Three omni wheels with M2006 motors: kinematics, speed loops, C610 frames. No hardware in here. */
#ifndef WHEELS_H
#define WHEELS_H

#include <stdbool.h>
#include <stdint.h>

#define WHEELS 3

typedef struct {
    float vx; /* m/s forward */
    float vy; /* m/s left */
    float omega; /* rad/s counter-clockwise */
} twist_t;

/* A feedback frame, 0x201 to 0x203. */
void wheels_feedback(uint16_t can_id, const uint8_t data[8], uint32_t now_ms);

/* What the robot has moved since it was asked last: mm, mm, rad, in its own frame. */
void wheels_moved(float *dx_mm, float *dy_mm, float *dtheta);

/* One millisecond of control: the command frame 0x200. NULL: no current. */
void wheels_step(const twist_t *wanted, uint32_t now_ms, uint8_t data[8]);

#endif
