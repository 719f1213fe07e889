/* Tasks; see FreeRTOS.h. */
#ifndef INC_TASK_H
#define INC_TASK_H

#include "FreeRTOS.h"

#ifdef __cplusplus
extern "C" {
#endif

BaseType_t xTaskCreate(
    TaskFunction_t function, const char *name, configSTACK_DEPTH_TYPE depth, void *given, UBaseType_t priority, TaskHandle_t *handle);
void vTaskDelete(TaskHandle_t task);
void vTaskStartScheduler(void);
void vTaskDelay(TickType_t ticks);
BaseType_t xTaskDelayUntil(TickType_t *last, TickType_t period);
#define vTaskDelayUntil(last, period) ((void)xTaskDelayUntil(last, period))
TickType_t xTaskGetTickCount(void);
TickType_t xTaskGetTickCountFromISR(void);
TaskHandle_t xTaskGetCurrentTaskHandle(void);
void taskYIELD(void);
void taskENTER_CRITICAL(void);
void taskEXIT_CRITICAL(void);
#define taskDISABLE_INTERRUPTS() taskENTER_CRITICAL()
#define taskENABLE_INTERRUPTS() taskEXIT_CRITICAL()
#define taskENTER_CRITICAL_FROM_ISR() 0U
#define taskEXIT_CRITICAL_FROM_ISR(mask) ((void)(mask))
void vTaskSuspendAll(void);
BaseType_t xTaskResumeAll(void);
BaseType_t xTaskNotifyGive(TaskHandle_t task);
void vTaskNotifyGiveFromISR(TaskHandle_t task, BaseType_t *wanted);
uint32_t ulTaskNotifyTake(BaseType_t clear, TickType_t ticks);

#ifdef __cplusplus
}
#endif
#endif
