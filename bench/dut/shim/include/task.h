/* Tasks; see FreeRTOS.h. */
#ifndef INC_TASK_H
#define INC_TASK_H

#include "FreeRTOS.h"

#ifdef __cplusplus
extern "C" {
#endif

BaseType_t xTaskCreate(
    TaskFunction_t function, const char *name, configSTACK_DEPTH_TYPE depth, void *given, UBaseType_t priority, TaskHandle_t *handle);
TaskHandle_t xTaskCreateStatic(
    TaskFunction_t function, const char *name, uint32_t depth, void *given, UBaseType_t priority, StackType_t *stack, StaticTask_t *memory);
void vTaskDelete(TaskHandle_t task);
void vTaskSuspend(TaskHandle_t task);
void vTaskResume(TaskHandle_t task);
BaseType_t xTaskResumeFromISR(TaskHandle_t task);
void vTaskPrioritySet(TaskHandle_t task, UBaseType_t priority);
UBaseType_t uxTaskPriorityGet(TaskHandle_t task);
UBaseType_t uxTaskGetStackHighWaterMark(TaskHandle_t task);
UBaseType_t uxTaskGetNumberOfTasks(void);
char *pcTaskGetName(TaskHandle_t task);
#define pcTaskGetTaskName(task) pcTaskGetName(task)
TaskHandle_t xTaskGetHandle(const char *name);
#define uxTaskPriorityGetFromISR(task) uxTaskPriorityGet(task)
typedef enum { eRunning = 0, eReady, eBlocked, eSuspended, eDeleted, eInvalid } eTaskState;
eTaskState eTaskGetState(TaskHandle_t task);
void vTaskList(char *to);
#define taskSCHEDULER_SUSPENDED ((BaseType_t)0)
#define taskSCHEDULER_NOT_STARTED ((BaseType_t)1)
#define taskSCHEDULER_RUNNING ((BaseType_t)2)
BaseType_t xTaskGetSchedulerState(void);
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
#define portENTER_CRITICAL() taskENTER_CRITICAL()
#define portEXIT_CRITICAL() taskEXIT_CRITICAL()
#define portDISABLE_INTERRUPTS() taskENTER_CRITICAL()
#define portENABLE_INTERRUPTS() taskEXIT_CRITICAL()
#define portSET_INTERRUPT_MASK_FROM_ISR() 0U
#define portCLEAR_INTERRUPT_MASK_FROM_ISR(mask) ((void)(mask))
void xPortSysTickHandler(void);
#define taskENTER_CRITICAL_FROM_ISR() 0U
#define taskEXIT_CRITICAL_FROM_ISR(mask) ((void)(mask))
void vTaskSuspendAll(void);
BaseType_t xTaskResumeAll(void);
BaseType_t xTaskNotifyGive(TaskHandle_t task);
void vTaskNotifyGiveFromISR(TaskHandle_t task, BaseType_t *wanted);
typedef enum { eNoAction = 0, eSetBits, eIncrement, eSetValueWithOverwrite, eSetValueWithoutOverwrite } eNotifyAction;
BaseType_t xTaskNotify(TaskHandle_t task, uint32_t value, eNotifyAction action);
BaseType_t xTaskNotifyFromISR(TaskHandle_t task, uint32_t value, eNotifyAction action, BaseType_t *wanted);
BaseType_t xTaskNotifyWait(uint32_t clear_before, uint32_t clear_after, uint32_t *value, TickType_t ticks);
BaseType_t xTaskNotifyStateClear(TaskHandle_t task);
uint32_t ulTaskNotifyValueClear(TaskHandle_t task, uint32_t bits);
uint32_t ulTaskNotifyTake(BaseType_t clear, TickType_t ticks);

#ifdef __cplusplus
}
#endif
#endif
