/* Tasks and queues: a receiver task, a core task, and control each millisecond. RC is i-BUS. */
#include "stm32f4xx_hal.h"

#include "FreeRTOS.h"
#include "queue.h"
#include "semphr.h"
#include "task.h"

#include "driver.h"
#include "slamware.h"

#include <string.h>

#define LENGTH 32
#define MIDDLE 1500
#define TRAVEL 500.0f
#define BEYOND 700 /* no stick goes there: the failsafe of the transmitter is set to less */
#define SWITCH 1700

/* BUG, found by `wheelbench failsafe`: the receiver task waits for ever for the next byte, and what it does about a
 * silent receiver comes after that wait. */
#ifdef FIXED
#define PATIENCE pdMS_TO_TICKS(5)
#else
#define PATIENCE portMAX_DELAY
#endif

CAN_HandleTypeDef hcan1;
UART_HandleTypeDef huart3, huart6;

static QueueHandle_t rc_bytes, core_bytes;
static SemaphoreHandle_t state;
static uint8_t rc_in[LENGTH], core_in;
static uint32_t last_frame_ms, silent_ms;
static bool has_frame;

typedef struct {
    uint8_t count, bytes[LENGTH];
} burst_t;

void HAL_UARTEx_RxEventCallback(UART_HandleTypeDef *uart, uint16_t size) {
    BaseType_t wanted = pdFALSE;
    if (uart != &huart3)
        return;
    burst_t burst = {.count = (uint8_t)size};
    memcpy(burst.bytes, rc_in, size);
    xQueueSendFromISR(rc_bytes, &burst, &wanted);
    HAL_UARTEx_ReceiveToIdle_DMA(&huart3, rc_in, LENGTH);
    portYIELD_FROM_ISR(wanted);
}

void HAL_UART_RxCpltCallback(UART_HandleTypeDef *uart) {
    BaseType_t wanted = pdFALSE;
    if (uart != &huart6)
        return;
    xQueueSendFromISR(core_bytes, &core_in, &wanted);
    HAL_UART_Receive_IT(&huart6, &core_in, 1);
    portYIELD_FROM_ISR(wanted);
}

static int channel(const uint8_t *frame, int number) {
    return (frame[2 + 2 * number] | frame[3 + 2 * number] << 8) & 0x0FFF;
}

static bool is_frame(const uint8_t *frame) {
    uint16_t sum = 0xFFFF;
    if (frame[0] != 0x20 || frame[1] != 0x40)
        return false;
    for (int i = 0; i < 30; i++)
        sum = (uint16_t)(sum - frame[i]);
    return sum == (frame[30] | frame[31] << 8);
}

static bool says_lost(const uint8_t *frame) {
    for (int i = 0; i < 4; i++)
        if (channel(frame, i) > MIDDLE + BEYOND || channel(frame, i) < MIDDLE - BEYOND || frame[3 + 2 * i] >> 4 == 0xC)
            return true;
    return false;
}

static void take_frame(const uint8_t *frame, uint32_t now_ms) {
    if (says_lost(frame)) {
        driver_failsafe();
        return;
    }
    sticks_t sticks = {
        .left = -(channel(frame, 0) - MIDDLE) / TRAVEL,
        .forward = (channel(frame, 1) - MIDDLE) / TRAVEL,
        .turn = -(channel(frame, 3) - MIDDLE) / TRAVEL,
        .arm = channel(frame, 4) >= SWITCH,
    };
    driver_frame(&sticks, now_ms);
    last_frame_ms = now_ms;
    has_frame = true;
}

static void receiver_task(void *unused) {
    static uint8_t window[LENGTH];
    burst_t burst;
    (void)unused;
    HAL_UARTEx_ReceiveToIdle_DMA(&huart3, rc_in, LENGTH);
    for (;;) {
        burst.count = 0;
        xQueueReceive(rc_bytes, &burst, PATIENCE);
        xSemaphoreTake(state, portMAX_DELAY);
        uint32_t now_ms = xTaskGetTickCount();
        for (int i = 0; i < burst.count; i++) {
            memmove(window, window + 1, LENGTH - 1);
            window[LENGTH - 1] = burst.bytes[i];
            if (is_frame(window))
                take_frame(window, now_ms);
        }
        silent_ms = now_ms - last_frame_ms;
        xSemaphoreGive(state);
    }
}

static void core_task(void *unused) {
    uint8_t byte, answer[64];
    (void)unused;
    HAL_UART_Receive_IT(&huart6, &core_in, 1);
    for (;;) {
        xQueueReceive(core_bytes, &byte, portMAX_DELAY);
        xSemaphoreTake(state, portMAX_DELAY);
        int size = slamware_byte(byte, xTaskGetTickCount(), answer);
        xSemaphoreGive(state);
        if (size)
            HAL_UART_Transmit(&huart6, answer, (uint16_t)size, 10);
    }
}

static void control_task(void *unused) {
    CAN_TxHeaderTypeDef out = {.StdId = 0x200, .IDE = CAN_ID_STD, .RTR = CAN_RTR_DATA, .DLC = 8};
    CAN_RxHeaderTypeDef in;
    TickType_t woken = xTaskGetTickCount();
    uint8_t data[8];
    uint32_t mailbox;
    (void)unused;
    for (;;) {
        uint32_t now_ms = xTaskGetTickCount();
        xSemaphoreTake(state, portMAX_DELAY);
        while (HAL_CAN_GetRxFifoFillLevel(&hcan1, CAN_RX_FIFO0) > 0)
            if (HAL_CAN_GetRxMessage(&hcan1, CAN_RX_FIFO0, &in, data) == HAL_OK)
                wheels_feedback((uint16_t)in.StdId, data, now_ms);
        wheels_step(has_frame ? driver_step(silent_ms, now_ms) : NULL, now_ms, data);
        xSemaphoreGive(state);
        HAL_CAN_AddTxMessage(&hcan1, &out, data, &mailbox);
        vTaskDelayUntil(&woken, pdMS_TO_TICKS(1));
    }
}

int main(void) {
    HAL_Init();
    HAL_CAN_Init(&hcan1);
    HAL_CAN_Start(&hcan1);
    HAL_UART_Init(&huart3);
    HAL_UART_Init(&huart6);
    rc_bytes = xQueueCreate(8, sizeof(burst_t));
    core_bytes = xQueueCreate(64, 1);
    state = xSemaphoreCreateMutex();
    xTaskCreate(receiver_task, "receiver", 256, NULL, 3, NULL);
    xTaskCreate(control_task, "control", 256, NULL, 2, NULL);
    xTaskCreate(core_task, "core", 256, NULL, 1, NULL);
    vTaskStartScheduler();
}
