#include "slamware.h"

#include "driver.h"

#include <string.h>

enum { STANDARD = 0x10, REQUEST = 0xF8, OK = 0x02, REFUSED = 0x03, NOT_SUPPORTED = 0x8000 };
enum { CONNECT = 0x10, POWER = 0x30, VELOCITY = 0x41 };

static uint8_t frame[64];
static int count;
static uint32_t heard_ms;

static int32_t q16_of(const uint8_t *at) {
    return (int32_t)((uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24);
}

static void put_q16(uint8_t *at, float value) {
    int32_t q16 = (int32_t)(value * 65536.0f);
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)((uint32_t)q16 >> 8 * i);
}

static int framed(uint8_t status, const uint8_t *payload, int size, uint8_t *answer) {
    answer[0] = STANDARD;
    answer[1] = (uint8_t)(size + 1);
    answer[2] = status;
    memcpy(answer + 3, payload, (size_t)size);
    answer[3 + size] = 0;
    for (int i = 0; i < 3 + size; i++)
        answer[3 + size] ^= answer[i];
    return size + 4;
}

static int answered(const uint8_t *payload, int size, uint32_t now_ms, uint8_t *answer) {
    uint8_t told[28] = {0};
    if (size >= 1 && payload[0] == CONNECT) {
        memcpy(told, "example", 7);
        told[12] = told[14] = 1;
        return framed(OK, told, 28, answer);
    }
    if (size == 1 && payload[0] == POWER) {
        told[0] = 100;
        return framed(OK, told, 2, answer);
    }
    if (size == 13 && payload[0] == VELOCITY) {
        twist_t twist = {q16_of(payload + 1) / 65536.0f, q16_of(payload + 5) / 65536.0f, q16_of(payload + 9) / 65536.0f};
        float dx_mm, dy_mm, dtheta;
        driver_core(&twist, now_ms);
        wheels_moved(&dx_mm, &dy_mm, &dtheta);
        put_q16(told, dx_mm);
        put_q16(told + 4, dy_mm);
        put_q16(told + 8, dtheta * 57.29578f);
        return framed(OK, told, 13, answer);
    }
    told[0] = NOT_SUPPORTED & 0xFF;
    told[1] = NOT_SUPPORTED >> 8;
    return framed(REFUSED, told, 2, answer);
}

int slamware_byte(uint8_t byte, uint32_t now_ms, uint8_t answer[64]) {
    if (now_ms - heard_ms > 100)
        count = 0; /* a frame that was cut */
    heard_ms = now_ms;
    if (count == 0 && byte != STANDARD)
        return 0;
    frame[count++] = byte;
    if (count < 2 || count < frame[1] + 3) {
        if (count == 2 && (byte == 0 || byte > 32))
            count = 0;
        return 0;
    }
    uint8_t check = 0;
    for (int i = 0; i < count; i++)
        check ^= frame[i];
    int size = count - 4;
    count = 0;
    if (check != 0 || frame[2] != REQUEST)
        return 0;
    return answered(frame + 3, size, now_ms, answer);
}
