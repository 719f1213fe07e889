/* Who drives: arming, a lost link, the sticks, the navigation core. No hardware and no protocol in here. */
#ifndef DRIVER_H
#define DRIVER_H

#include "wheels.h"

typedef struct {
    float forward, left, turn; /* -1 to 1 */
    bool arm; /* the switch */
} sticks_t;

#define HOLD_MS 100
#define DISARM_MS 500

/* A good frame of the receiver. */
void driver_frame(const sticks_t *sticks, uint32_t now_ms);

/* A frame that says that the link is gone. */
void driver_failsafe(void);

/* What the core asks for. */
void driver_core(const twist_t *twist, uint32_t now_ms);

/* One millisecond; `silent_ms` since the last good frame. What the robot shall do, or NULL: no current. */
const twist_t *driver_step(uint32_t silent_ms, uint32_t now_ms);

#endif
