/* CMSIS-RTOS, version 1 and 2, as generated projects use it, on the same scheduler; see FreeRTOS.h. MIT licence. */
#ifndef CMSIS_OS_H_
#define CMSIS_OS_H_

#include "FreeRTOS.h"
#include "event_groups.h"
#include "queue.h"
#include "semphr.h"
#include "task.h"
#include "timers.h"

#ifdef __cplusplus
extern "C" {
#endif

#define osWaitForever 0xFFFFFFFFU
#define osFlagsWaitAny 0U
#define osFlagsWaitAll 1U
#define osFlagsNoClear 2U
#define osFlagsError 0x80000000U
#define osFlagsErrorTimeout 0xFFFFFFFEU
#define osFlagsErrorResource 0xFFFFFFFDU

typedef enum {
    osOK = 0, osError = -1, osErrorTimeout = -2, osErrorResource = -3, osErrorParameter = -4, osErrorNoMemory = -5, osErrorISR = -6,
    osEventSignal = 8, osEventMessage = 0x10, osEventMail = 0x20, osEventTimeout = 0x40, osErrorOS = 0xFF /* version 1 */
} osStatus_t;
typedef enum {
    osPriorityNone = 0, osPriorityIdle = 1,
    osPriorityLow = 8, osPriorityLow1, osPriorityLow2, osPriorityLow3, osPriorityLow4, osPriorityLow5, osPriorityLow6, osPriorityLow7,
    osPriorityBelowNormal = 16, osPriorityBelowNormal1, osPriorityBelowNormal2, osPriorityBelowNormal3, osPriorityBelowNormal4, osPriorityBelowNormal5, osPriorityBelowNormal6, osPriorityBelowNormal7,
    osPriorityNormal = 24, osPriorityNormal1, osPriorityNormal2, osPriorityNormal3, osPriorityNormal4, osPriorityNormal5, osPriorityNormal6, osPriorityNormal7,
    osPriorityAboveNormal = 32, osPriorityAboveNormal1, osPriorityAboveNormal2, osPriorityAboveNormal3, osPriorityAboveNormal4, osPriorityAboveNormal5, osPriorityAboveNormal6, osPriorityAboveNormal7,
    osPriorityHigh = 40, osPriorityHigh1, osPriorityHigh2, osPriorityHigh3, osPriorityHigh4, osPriorityHigh5, osPriorityHigh6, osPriorityHigh7,
    osPriorityRealtime = 48, osPriorityRealtime1, osPriorityRealtime2, osPriorityRealtime3, osPriorityRealtime4, osPriorityRealtime5, osPriorityRealtime6, osPriorityRealtime7,
    osPriorityISR = 56
} osPriority_t;
typedef enum { osTimerOnce = 0, osTimerPeriodic = 1 } osTimerType_t;
typedef void *osThreadId_t, *osMutexId_t, *osSemaphoreId_t, *osMessageQueueId_t, *osTimerId_t, *osEventFlagsId_t;
typedef void (*osThreadFunc_t)(void *);
typedef void (*osTimerFunc_t)(void *);
typedef struct {
    const char *name;
    uint32_t attr_bits;
    void *cb_mem;
    uint32_t cb_size;
    void *stack_mem;
    uint32_t stack_size;
    osPriority_t priority;
    uint32_t tz_module, reserved;
} osThreadAttr_t;
typedef struct {
    const char *name;
    uint32_t attr_bits;
    void *cb_mem;
    uint32_t cb_size;
    void *mq_mem;
    uint32_t mq_size;
} osMutexAttr_t, osSemaphoreAttr_t, osTimerAttr_t, osEventFlagsAttr_t, osMessageQueueAttr_t;
#define osMutexRecursive 1U
#define osMutexPrioInherit 2U

/* Both versions. */
osStatus_t osKernelInitialize(void);
osStatus_t osKernelStart(void);
osThreadId_t osThreadGetId(void);
osStatus_t osThreadYield(void);
osStatus_t osThreadTerminate(osThreadId_t thread);
osStatus_t osDelay(uint32_t ticks);
osStatus_t osMutexRelease(osMutexId_t mutex);
osStatus_t osSemaphoreRelease(osSemaphoreId_t semaphore);
osStatus_t osTimerStart(osTimerId_t timer, uint32_t ticks);
osStatus_t osTimerStop(osTimerId_t timer);

/* Version 2. */
uint32_t osKernelGetTickCount(void);
#define osKernelGetTickFreq() 1000U
osThreadId_t osThreadNew(osThreadFunc_t function, void *given, const osThreadAttr_t *attributes);
void osThreadExit(void);
osStatus_t osThreadSuspend(osThreadId_t thread);
osStatus_t osThreadResume(osThreadId_t thread);
uint32_t osThreadFlagsSet(osThreadId_t thread, uint32_t flags);
uint32_t osThreadFlagsClear(uint32_t flags);
uint32_t osThreadFlagsWait(uint32_t flags, uint32_t options, uint32_t ticks);
osMutexId_t osMutexNew(const osMutexAttr_t *attributes);
osStatus_t osMutexAcquire(osMutexId_t mutex, uint32_t ticks);
osSemaphoreId_t osSemaphoreNew(uint32_t most, uint32_t first, const osSemaphoreAttr_t *attributes);
osStatus_t osSemaphoreAcquire(osSemaphoreId_t semaphore, uint32_t ticks);
uint32_t osSemaphoreGetCount(osSemaphoreId_t semaphore);
osMessageQueueId_t osMessageQueueNew(uint32_t length, uint32_t item_size, const osMessageQueueAttr_t *attributes);
osStatus_t osMessageQueuePut(osMessageQueueId_t queue, const void *item, uint8_t priority, uint32_t ticks);
osStatus_t osMessageQueueGet(osMessageQueueId_t queue, void *item, uint8_t *priority, uint32_t ticks);
uint32_t osMessageQueueGetCount(osMessageQueueId_t queue);
osStatus_t osMessageQueueReset(osMessageQueueId_t queue);
osEventFlagsId_t osEventFlagsNew(const osEventFlagsAttr_t *attributes);
uint32_t osEventFlagsSet(osEventFlagsId_t group, uint32_t flags);
uint32_t osEventFlagsClear(osEventFlagsId_t group, uint32_t flags);
uint32_t osEventFlagsWait(osEventFlagsId_t group, uint32_t flags, uint32_t options, uint32_t ticks);
osTimerId_t osTimerNew(osTimerFunc_t call, osTimerType_t type, void *given, const osTimerAttr_t *attributes);

/* Version 1. */
typedef osStatus_t osStatus;
typedef osPriority_t osPriority;
typedef osThreadId_t osThreadId;
typedef osMutexId_t osMutexId;
typedef osSemaphoreId_t osSemaphoreId;
typedef osMessageQueueId_t osMessageQId;
typedef osTimerId_t osTimerId;
typedef StaticTask_t osStaticThreadDef_t;
typedef StaticQueue_t osStaticMessageQDef_t;
typedef StaticSemaphore_t osStaticMutexDef_t, osStaticSemaphoreDef_t;
typedef StaticTimer_t osStaticTimerDef_t;
typedef void (*os_pthread)(void const *given);
typedef struct {
    const char *name;
    os_pthread function;
    osPriority_t priority;
} osThreadDef_t;
typedef struct {
    uint32_t length;
} osMessageQDef_t;
typedef struct {
    uint32_t unused;
} osMutexDef_t, osSemaphoreDef_t;
typedef struct {
    os_pthread call;
} osTimerDef_t;
typedef struct {
    osStatus_t status;
    union {
        uint32_t v;
        void *p;
        int32_t signals;
    } value;
} osEvent;
#define osThreadDef(called, thread, level, instances, depth) \
    const osThreadDef_t os_thread_def_##called = {#called, (thread), (level)}
#define osThreadStaticDef(called, thread, level, instances, depth, stack, memory) \
    osThreadDef(called, thread, level, instances, depth)
#define osThread(called) (&os_thread_def_##called)
#define osMutexDef(called) const osMutexDef_t os_mutex_def_##called = {0}
#define osMutexStaticDef(called, memory) osMutexDef(called)
#define osMutex(called) (&os_mutex_def_##called)
#define osSemaphoreDef(called) const osSemaphoreDef_t os_semaphore_def_##called = {0}
#define osSemaphoreStaticDef(called, memory) osSemaphoreDef(called)
#define osSemaphore(called) (&os_semaphore_def_##called)
#define osMessageQDef(called, size, type) const osMessageQDef_t os_messageQ_def_##called = {(size)}
#define osMessageQStaticDef(called, size, type, items, memory) osMessageQDef(called, size, type)
#define osMessageQ(called) (&os_messageQ_def_##called)
#define osTimerDef(called, function) const osTimerDef_t os_timer_def_##called = {(function)}
#define osTimerStaticDef(called, function, memory) osTimerDef(called, function)
#define osTimer(called) (&os_timer_def_##called)
#define osKernelSysTick() osKernelGetTickCount()
osThreadId osThreadCreate(const osThreadDef_t *definition, void *given);
osMutexId osMutexCreate(const osMutexDef_t *definition);
osStatus osMutexWait(osMutexId mutex, uint32_t ticks);
osSemaphoreId osSemaphoreCreate(const osSemaphoreDef_t *definition, int32_t count);
int32_t osSemaphoreWait(osSemaphoreId semaphore, uint32_t ticks);
osMessageQId osMessageCreate(const osMessageQDef_t *definition, osThreadId thread);
osStatus osMessagePut(osMessageQId queue, uint32_t what, uint32_t ticks);
osEvent osMessageGet(osMessageQId queue, uint32_t ticks);
int32_t osSignalSet(osThreadId thread, int32_t signals);
osEvent osSignalWait(int32_t signals, uint32_t ticks);
osTimerId osTimerCreate(const osTimerDef_t *definition, osTimerType_t type, void *given);

#define osMessageWaiting(queue) osMessageQueueGetCount(queue)

/* osDelayUntil(tick) in version 2, osDelayUntil(&last, period) in version 1. */
osStatus_t wb_os_delay_until(uint32_t tick);
osStatus_t wb_os_delay_period(uint32_t *last, uint32_t period);
#define WB_DELAY_UNTIL_OF(one, two, chosen, ...) chosen
#define osDelayUntil(...) WB_DELAY_UNTIL_OF(__VA_ARGS__, wb_os_delay_period, wb_os_delay_until, 0)(__VA_ARGS__)

#ifdef __cplusplus
}
#endif
#endif
