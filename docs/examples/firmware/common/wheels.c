#include "wheels.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265f
#define COUNTS 8192
#define GEAR 36.0f
#define RADIUS 0.027f
#define DISTANCE 0.061f
#define CURRENT_LIMIT 0.6f
#define WHEEL_LIMIT 37.0f
#define FEEDBACK_TIMEOUT_MS 20
#define KP 1.0f /* A per rad/s of the wheel */
#define KI 0.02f /* A per rad/s, each millisecond */

/* Bearings -75, 180 and 75 degrees; positive is the counter-clockwise tangent. The motors are mounted the other way. */
static const float tangent_x[WHEELS] = {0.9659258f, 0.0f, -0.9659258f};
static const float tangent_y[WHEELS] = {0.2588190f, -1.0f, 0.2588190f};
static const float MOUNTED = -1.0f;

static struct {
    uint16_t angle;
    uint32_t heard_ms;
    bool is_known;
    float speed; /* rad/s of the wheel */
    float turned; /* rad since wheels_moved */
    float integral;
} wheel[WHEELS];

void wheels_feedback(uint16_t can_id, const uint8_t data[8], uint32_t now_ms) {
    if (can_id < 0x201 || can_id >= 0x201 + WHEELS)
        return;
    int i = can_id - 0x201;
    uint16_t angle = (uint16_t)(data[0] << 8 | data[1]);
    if (wheel[i].is_known) {
        int step = (angle - wheel[i].angle + COUNTS + COUNTS / 2) % COUNTS - COUNTS / 2;
        float turned = MOUNTED * step * (2.0f * PI / COUNTS / GEAR);
        uint32_t gap_ms = now_ms - wheel[i].heard_ms;
        wheel[i].speed = turned * 1000.0f / (gap_ms ? gap_ms : 1);
        wheel[i].turned += turned;
    }
    wheel[i].angle = angle;
    wheel[i].heard_ms = now_ms;
    wheel[i].is_known = true;
}

void wheels_moved(float *dx_mm, float *dy_mm, float *dtheta) {
    float x = 0.0f, y = 0.0f, turn = 0.0f;
    for (int i = 0; i < WHEELS; i++) {
        float rim = wheel[i].turned * RADIUS;
        x += tangent_x[i] * rim;
        y += tangent_y[i] * rim;
        turn += rim;
        wheel[i].turned = 0.0f;
    }
    /* The inverse of the wheels' equations; the three rows are not quite orthogonal, so sums have to be taken apart. */
    float s = tangent_x[0], c = tangent_y[0], sum = 2.0f * c * c + 1.0f - (2.0f * c - 1.0f) * (2.0f * c - 1.0f) / 3.0f;
    *dx_mm = 1000.0f * x / (2.0f * s * s);
    float across = (y - (2.0f * c - 1.0f) * turn / 3.0f) / sum;
    *dy_mm = 1000.0f * across;
    *dtheta = (turn - (2.0f * c - 1.0f) * across) / (3.0f * DISTANCE);
}

static bool all_heard(uint32_t now_ms) {
    for (int i = 0; i < WHEELS; i++)
        if (!wheel[i].is_known || now_ms - wheel[i].heard_ms >= FEEDBACK_TIMEOUT_MS)
            return false;
    return true;
}

static float within(float value, float limit) {
    return value > limit ? limit : value < -limit ? -limit : value;
}

void wheels_step(const twist_t *wanted, uint32_t now_ms, uint8_t data[8]) {
    memset(data, 0, 8);
    if (!wanted || !all_heard(now_ms)) { /* a robot that cannot feel a wheel must not push it */
        for (int i = 0; i < WHEELS; i++)
            wheel[i].integral = 0.0f;
        return;
    }
    float speed[WHEELS], fastest = WHEEL_LIMIT;
    for (int i = 0; i < WHEELS; i++) {
        speed[i] = (tangent_x[i] * wanted->vx + tangent_y[i] * wanted->vy + DISTANCE * wanted->omega) / RADIUS;
        fastest = fmaxf(fastest, fabsf(speed[i]));
    }
    bool is_rest = wanted->vx == 0.0f && wanted->vy == 0.0f && wanted->omega == 0.0f;
    for (int i = 0; i < WHEELS; i++) {
        float error = speed[i] * (WHEEL_LIMIT / fastest) - wheel[i].speed;
        /* At rest there is nothing to hold against: what was summed up on the way would push on. */
        wheel[i].integral = is_rest ? 0.0f : within(wheel[i].integral + KI * error, CURRENT_LIMIT);
        float current = within(KP * error + wheel[i].integral, CURRENT_LIMIT);
        int16_t milliamperes = (int16_t)(MOUNTED * current * 1000.0f);
        data[2 * i] = (uint8_t)((uint16_t)milliamperes >> 8);
        data[2 * i + 1] = (uint8_t)milliamperes;
    }
}
