#include "driver.h"

#include <math.h>
#include <stddef.h>

#define DEAD_BAND 0.05f
#define FULL_SPEED 1.0f
#define FULL_TURN 2.0f
#define HANDOVER_MS 500
#define CORE_TIMEOUT_MS 1000

static const twist_t REST;
static sticks_t sticks;
static bool is_armed, was_pressed = true, is_stopped;
static uint32_t touched_ms;
static twist_t core, wanted;
static uint32_t core_ms;
static bool core_is_known;

static bool at_rest(void) {
    return fabsf(sticks.forward) < DEAD_BAND && fabsf(sticks.left) < DEAD_BAND && fabsf(sticks.turn) < DEAD_BAND;
}

void driver_frame(const sticks_t *now, uint32_t now_ms) {
    sticks = *now;
    is_stopped = false;
    if (!at_rest())
        touched_ms = now_ms;
    if (sticks.arm && !was_pressed) {
        is_armed = !is_armed && at_rest();
        touched_ms = now_ms;
    }
    was_pressed = sticks.arm;
}

void driver_failsafe(void) {
    is_stopped = true;
}

void driver_core(const twist_t *twist, uint32_t now_ms) {
    core = *twist;
    core_ms = now_ms;
    core_is_known = true;
}

static float shaped(float stick) {
    if (fabsf(stick) < DEAD_BAND)
        return 0.0f;
    return copysignf((fabsf(stick) - DEAD_BAND) / (1.0f - DEAD_BAND), stick);
}

const twist_t *driver_step(uint32_t silent_ms, uint32_t now_ms) {
    if (silent_ms >= DISARM_MS) {
        is_armed = false;
        was_pressed = true; /* the switch has to be seen released first */
    }
    if (!is_armed)
        return NULL;
    if (silent_ms >= HOLD_MS || is_stopped)
        return &REST;
    if (at_rest() && now_ms - touched_ms >= HANDOVER_MS && core_is_known && now_ms - core_ms <= CORE_TIMEOUT_MS)
        return &core;
    wanted.vx = FULL_SPEED * shaped(sticks.forward);
    wanted.vy = FULL_SPEED * shaped(sticks.left);
    wanted.omega = FULL_TURN * shaped(sticks.turn);
    return &wanted;
}
