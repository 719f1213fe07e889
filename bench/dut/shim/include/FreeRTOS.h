/* As much of the FreeRTOS interface as a wheel base's own files use; rtos.c has the scheduler behind it.
 *
 * Written from the interface's public documentation; nothing is copied from it. MIT licence.
 */
#ifndef INC_FREERTOS_H
#define INC_FREERTOS_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef long BaseType_t;
typedef unsigned long UBaseType_t;
typedef uint32_t TickType_t;
typedef uint32_t StackType_t;
typedef uint16_t configSTACK_DEPTH_TYPE;
typedef void (*TaskFunction_t)(void *);
typedef struct wb_task *TaskHandle_t;
typedef struct wb_queue *QueueHandle_t;
typedef QueueHandle_t SemaphoreHandle_t;
/* Names of old, which generators still write. */
typedef TaskHandle_t xTaskHandle;
typedef QueueHandle_t xQueueHandle;
typedef SemaphoreHandle_t xSemaphoreHandle;
typedef TickType_t portTickType;
#define portBASE_TYPE long
#define portCHAR char
#define portLONG long
#define portSHORT short
#define portFLOAT float
#define portDOUBLE double
/* Memory that a firmware gives to something is not used: everything has its own. */
typedef struct {
    uint32_t unused;
} StaticTask_t, StaticQueue_t, StaticSemaphore_t, StaticTimer_t, StaticEventGroup_t;

#define pdFALSE ((BaseType_t)0)
#define pdTRUE ((BaseType_t)1)
#define pdFAIL pdFALSE
#define pdPASS pdTRUE
#define errQUEUE_FULL pdFALSE
#define errQUEUE_EMPTY pdFALSE
#define portMAX_DELAY ((TickType_t)0xFFFFFFFFU)
#define configTICK_RATE_HZ ((TickType_t)1000)
#define configMINIMAL_STACK_SIZE ((configSTACK_DEPTH_TYPE)128)
#define configMAX_PRIORITIES 56
#define configASSERT(truth) ((truth) ? (void)0 : wb_rtos_assert(__FILE__, __LINE__, #truth))
#define portTICK_PERIOD_MS ((TickType_t)1)
#define portTICK_RATE_MS portTICK_PERIOD_MS
#define pdMS_TO_TICKS(ms) ((TickType_t)(ms))
#define pdTICKS_TO_MS(ticks) ((TickType_t)(ticks))
#define configMAX_TASK_NAME_LEN 16
#define tskIDLE_PRIORITY ((UBaseType_t)0)
#define portYIELD_FROM_ISR(wanted) ((void)(wanted))
#define portYIELD() taskYIELD()
#define portEND_SWITCHING_ISR(wanted) ((void)(wanted))

void wb_rtos_assert(const char *file, int line, const char *truth);
void *pvPortMalloc(size_t size);
void vPortFree(void *block);
size_t xPortGetFreeHeapSize(void);
#define xPortGetMinimumEverFreeHeapSize() xPortGetFreeHeapSize()
BaseType_t xPortIsInsideInterrupt(void);

#ifdef __cplusplus
}
#endif
#endif
