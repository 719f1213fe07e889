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
#define osFlagsErrorParameter 0xFFFFFFFCU
#define osFlagsErrorISR 0xFFFFFFFAU

typedef enum {
    osOK = 0, osError = -1, osErrorTimeout = -2, osErrorResource = -3, osErrorParameter = -4, osErrorNoMemory = -5, osErrorISR = -6,
    osEventSignal = 8, osEventMessage = 0x10, osEventMail = 0x20, osEventTimeout = 0x40, osErrorTimeoutResource = 0xC1,
    osErrorISRRecursive = 0x83, osErrorPriority = 0x84, osErrorValue = 0x86, osErrorOS = 0xFF /* version 1 */
} osStatus_t;
typedef enum {
    osPriorityNone = 0, osPriorityIdle = 1,
    osPriorityLow = 8, osPriorityLow1, osPriorityLow2, osPriorityLow3, osPriorityLow4, osPriorityLow5, osPriorityLow6, osPriorityLow7,
    osPriorityBelowNormal = 16, osPriorityBelowNormal1, osPriorityBelowNormal2, osPriorityBelowNormal3, osPriorityBelowNormal4, osPriorityBelowNormal5, osPriorityBelowNormal6, osPriorityBelowNormal7,
    osPriorityNormal = 24, osPriorityNormal1, osPriorityNormal2, osPriorityNormal3, osPriorityNormal4, osPriorityNormal5, osPriorityNormal6, osPriorityNormal7,
    osPriorityAboveNormal = 32, osPriorityAboveNormal1, osPriorityAboveNormal2, osPriorityAboveNormal3, osPriorityAboveNormal4, osPriorityAboveNormal5, osPriorityAboveNormal6, osPriorityAboveNormal7,
    osPriorityHigh = 40, osPriorityHigh1, osPriorityHigh2, osPriorityHigh3, osPriorityHigh4, osPriorityHigh5, osPriorityHigh6, osPriorityHigh7,
    osPriorityRealtime = 48, osPriorityRealtime1, osPriorityRealtime2, osPriorityRealtime3, osPriorityRealtime4, osPriorityRealtime5, osPriorityRealtime6, osPriorityRealtime7,
    osPriorityISR = 56, osPriorityError = -1
} osPriority_t;
typedef enum {
    osThreadInactive = 0, osThreadReady = 1, osThreadRunning = 2, osThreadBlocked = 3, osThreadTerminated = 4,
    osThreadDeleted = 4, osThreadSuspended = 5 /* both of version 1; in version 2 it is blocked */, osThreadError = -1
} osThreadState_t;
typedef enum {
    osKernelInactive = 0, osKernelReady = 1, osKernelRunning = 2, osKernelLocked = 3, osKernelError = -1
} osKernelState_t;
typedef enum { osTimerOnce = 0, osTimerPeriodic = 1 } osTimerType_t;
typedef void *osThreadId_t, *osMutexId_t, *osSemaphoreId_t, *osMessageQueueId_t, *osTimerId_t, *osEventFlagsId_t;
typedef struct wb_pool *osMemoryPoolId_t;
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
typedef struct {
    const char *name;
    uint32_t attr_bits;
    void *cb_mem;
    uint32_t cb_size;
    void *mp_mem;
    uint32_t mp_size;
} osMemoryPoolAttr_t;
#define osThreadDetached 0U
#define osThreadJoinable 1U
#define osMutexRobust 8U
#define osMutexRecursive 1U
#define osMutexPrioInherit 2U

/* Both versions. */
osStatus_t osKernelInitialize(void);
osStatus_t osKernelStart(void);
osThreadId_t osThreadGetId(void);
osStatus_t osThreadYield(void);
osStatus_t osThreadTerminate(osThreadId_t thread);
osStatus_t osThreadSuspend(osThreadId_t thread);
osStatus_t osThreadResume(osThreadId_t thread);
osStatus_t osThreadSetPriority(osThreadId_t thread, osPriority_t priority);
osPriority_t osThreadGetPriority(osThreadId_t thread);
osThreadState_t osThreadGetState(osThreadId_t thread);
osStatus_t osDelay(uint32_t ticks);
osStatus_t osMutexRelease(osMutexId_t mutex);
osStatus_t osMutexDelete(osMutexId_t mutex);
osStatus_t osSemaphoreRelease(osSemaphoreId_t semaphore);
osStatus_t osSemaphoreDelete(osSemaphoreId_t semaphore);
uint32_t osSemaphoreGetCount(osSemaphoreId_t semaphore);
osStatus_t osTimerStart(osTimerId_t timer, uint32_t ticks);
osStatus_t osTimerStop(osTimerId_t timer);
osStatus_t osTimerDelete(osTimerId_t timer);

/* Version 2. */
osKernelState_t osKernelGetState(void);
int32_t osKernelLock(void);
int32_t osKernelUnlock(void);
int32_t osKernelRestoreLock(int32_t lock);
uint32_t osKernelGetTickCount(void);
uint32_t osKernelGetSysTimerCount(void);
uint32_t osKernelGetSysTimerFreq(void);
#define osKernelGetTickFreq() 1000U
osThreadId_t osThreadNew(osThreadFunc_t function, void *given, const osThreadAttr_t *attributes);
void osThreadExit(void);
const char *osThreadGetName(osThreadId_t thread);
uint32_t osThreadGetCount(void);
uint32_t osThreadGetStackSpace(osThreadId_t thread);
uint32_t osThreadFlagsSet(osThreadId_t thread, uint32_t flags);
uint32_t osThreadFlagsClear(uint32_t flags);
uint32_t osThreadFlagsGet(void);
uint32_t osThreadFlagsWait(uint32_t flags, uint32_t options, uint32_t ticks);
osMutexId_t osMutexNew(const osMutexAttr_t *attributes);
osStatus_t osMutexAcquire(osMutexId_t mutex, uint32_t ticks);
osSemaphoreId_t osSemaphoreNew(uint32_t most, uint32_t first, const osSemaphoreAttr_t *attributes);
osStatus_t osSemaphoreAcquire(osSemaphoreId_t semaphore, uint32_t ticks);
osMessageQueueId_t osMessageQueueNew(uint32_t length, uint32_t item_size, const osMessageQueueAttr_t *attributes);
osStatus_t osMessageQueuePut(osMessageQueueId_t queue, const void *item, uint8_t priority, uint32_t ticks);
osStatus_t osMessageQueueGet(osMessageQueueId_t queue, void *item, uint8_t *priority, uint32_t ticks);
uint32_t osMessageQueueGetCapacity(osMessageQueueId_t queue);
uint32_t osMessageQueueGetMsgSize(osMessageQueueId_t queue);
uint32_t osMessageQueueGetCount(osMessageQueueId_t queue);
uint32_t osMessageQueueGetSpace(osMessageQueueId_t queue);
osStatus_t osMessageQueueReset(osMessageQueueId_t queue);
osStatus_t osMessageQueueDelete(osMessageQueueId_t queue);
osEventFlagsId_t osEventFlagsNew(const osEventFlagsAttr_t *attributes);
uint32_t osEventFlagsSet(osEventFlagsId_t group, uint32_t flags);
uint32_t osEventFlagsClear(osEventFlagsId_t group, uint32_t flags);
uint32_t osEventFlagsGet(osEventFlagsId_t group);
uint32_t osEventFlagsWait(osEventFlagsId_t group, uint32_t flags, uint32_t options, uint32_t ticks);
osStatus_t osEventFlagsDelete(osEventFlagsId_t group);
osTimerId_t osTimerNew(osTimerFunc_t call, osTimerType_t type, void *given, const osTimerAttr_t *attributes);
uint32_t osTimerIsRunning(osTimerId_t timer);
osMemoryPoolId_t osMemoryPoolNew(uint32_t blocks, uint32_t block_size, const osMemoryPoolAttr_t *attributes);
void *osMemoryPoolAlloc(osMemoryPoolId_t pool, uint32_t ticks);
osStatus_t osMemoryPoolFree(osMemoryPoolId_t pool, void *block);
uint32_t osMemoryPoolGetCapacity(osMemoryPoolId_t pool);
uint32_t osMemoryPoolGetBlockSize(osMemoryPoolId_t pool);
uint32_t osMemoryPoolGetCount(osMemoryPoolId_t pool);
uint32_t osMemoryPoolGetSpace(osMemoryPoolId_t pool);
osStatus_t osMemoryPoolDelete(osMemoryPoolId_t pool);

/* Version 1. */
typedef osStatus_t osStatus;
typedef osPriority_t osPriority;
typedef osThreadState_t osThreadState;
typedef osTimerType_t os_timer_type;
typedef osThreadId_t osThreadId;
typedef osMutexId_t osMutexId;
typedef osSemaphoreId_t osSemaphoreId;
typedef osMessageQueueId_t osMessageQId;
typedef osTimerId_t osTimerId;
typedef struct wb_pool *osPoolId;
typedef struct wb_mail *osMailQId;
typedef StaticTask_t osStaticThreadDef_t;
typedef StaticQueue_t osStaticMessageQDef_t;
typedef StaticSemaphore_t osStaticMutexDef_t, osStaticSemaphoreDef_t;
typedef StaticTimer_t osStaticTimerDef_t;
typedef void (*os_pthread)(void const *given);
typedef void (*os_ptimer)(void const *given);
typedef struct {
    const char *name;
    os_pthread pthread;
    osPriority tpriority;
    uint32_t instances, stacksize;
    void *buffer;
    osStaticThreadDef_t *controlblock;
} osThreadDef_t;
typedef struct {
    uint32_t queue_sz, item_sz;
    uint8_t *buffer;
    osStaticMessageQDef_t *controlblock;
} osMessageQDef_t;
typedef struct {
    uint32_t dummy;
    StaticSemaphore_t *controlblock;
} osMutexDef_t, osSemaphoreDef_t;
typedef struct {
    os_ptimer ptimer;
    osStaticTimerDef_t *controlblock;
} osTimerDef_t;
typedef struct {
    uint32_t pool_sz, item_sz;
} osPoolDef_t;
typedef struct {
    uint32_t queue_sz, item_sz;
} osMailQDef_t;
typedef struct {
    osStatus_t status;
    union {
        uint32_t v;
        void *p;
        int32_t signals;
    } value;
    union {
        osMailQId mail_id;
        osMessageQId message_id;
    } def;
} osEvent;
#define osThreadStaticDef(called, thread, level, instances, depth, stack, memory) \
    const osThreadDef_t os_thread_def_##called = {#called, (thread), (level), (instances), (depth), (stack), (memory)}
#define osThreadDef(called, thread, level, instances, depth) \
    osThreadStaticDef(called, thread, level, instances, depth, NULL, NULL)
#define osThread(called) (&os_thread_def_##called)
#define osMutexStaticDef(called, memory) const osMutexDef_t os_mutex_def_##called = {0, (memory)}
#define osMutexDef(called) osMutexStaticDef(called, NULL)
#define osMutex(called) (&os_mutex_def_##called)
#define osSemaphoreStaticDef(called, memory) const osSemaphoreDef_t os_semaphore_def_##called = {0, (memory)}
#define osSemaphoreDef(called) osSemaphoreStaticDef(called, NULL)
#define osSemaphore(called) (&os_semaphore_def_##called)
#define osMessageQStaticDef(called, size, type, items, memory) \
    const osMessageQDef_t os_messageQ_def_##called = {(size), sizeof(type), (items), (memory)}
#define osMessageQDef(called, size, type) osMessageQStaticDef(called, size, type, NULL, NULL)
#define osMessageQ(called) (&os_messageQ_def_##called)
#define osTimerStaticDef(called, function, memory) const osTimerDef_t os_timer_def_##called = {(function), (memory)}
#define osTimerDef(called, function) osTimerStaticDef(called, function, NULL)
#define osTimer(called) (&os_timer_def_##called)
#define osPoolDef(called, size, type) const osPoolDef_t os_pool_def_##called = {(size), sizeof(type)}
#define osPool(called) (&os_pool_def_##called)
#define osMailQDef(called, size, type) const osMailQDef_t os_mailQ_def_##called = {(size), sizeof(type)}
#define osMailQ(called) (&os_mailQ_def_##called)
#define osKernelSysTick() osKernelGetTickCount()
#define osKernelSysTickFrequency 1000U
#define osKernelSysTickMicroSec(us) ((uint32_t)((uint64_t)(us) * osKernelSysTickFrequency / 1000000U))
#define osKernelRunning() ((int32_t)(osKernelGetState() >= osKernelRunning)) /* without brackets a state of version 2 */
void osSystickHandler(void);
osThreadId osThreadCreate(const osThreadDef_t *definition, void *given);
osStatus osThreadIsSuspended(osThreadId thread);
osStatus osThreadSuspendAll(void);
osStatus osThreadResumeAll(void);
osMutexId osMutexCreate(const osMutexDef_t *definition);
osStatus osMutexWait(osMutexId mutex, uint32_t ticks);
osMutexId osRecursiveMutexCreate(const osMutexDef_t *definition);
osStatus osRecursiveMutexWait(osMutexId mutex, uint32_t ticks);
osStatus osRecursiveMutexRelease(osMutexId mutex);
osSemaphoreId osSemaphoreCreate(const osSemaphoreDef_t *definition, int32_t count);
int32_t osSemaphoreWait(osSemaphoreId semaphore, uint32_t ticks);
osMessageQId osMessageCreate(const osMessageQDef_t *definition, osThreadId thread);
osStatus osMessagePut(osMessageQId queue, uint32_t what, uint32_t ticks);
osEvent osMessageGet(osMessageQId queue, uint32_t ticks);
osEvent osMessagePeek(osMessageQId queue, uint32_t ticks);
#define osMessageWaiting(queue) osMessageQueueGetCount(queue)
#define osMessageAvailableSpace(queue) osMessageQueueGetSpace(queue)
#define osMessageDelete(queue) osMessageQueueDelete(queue)
int32_t osSignalSet(osThreadId thread, int32_t signals);
int32_t osSignalClear(osThreadId thread, int32_t signals);
osEvent osSignalWait(int32_t signals, uint32_t ticks);
osTimerId osTimerCreate(const osTimerDef_t *definition, os_timer_type type, void *given);
osPoolId osPoolCreate(const osPoolDef_t *definition);
void *osPoolAlloc(osPoolId pool);
void *osPoolCAlloc(osPoolId pool);
osStatus osPoolFree(osPoolId pool, void *block);
osMailQId osMailCreate(const osMailQDef_t *definition, osThreadId thread);
void *osMailAlloc(osMailQId queue, uint32_t ticks);
void *osMailCAlloc(osMailQId queue, uint32_t ticks);
osStatus osMailPut(osMailQId queue, void *mail);
osEvent osMailGet(osMailQId queue, uint32_t ticks);
osStatus osMailFree(osMailQId queue, void *mail);

/* osDelayUntil(tick) in version 2, osDelayUntil(&last, period) in version 1. */
osStatus_t wb_os_delay_until(uint32_t tick);
osStatus_t wb_os_delay_period(uint32_t *last, uint32_t period);
#define WB_DELAY_UNTIL_OF(one, two, chosen, ...) chosen
#define osDelayUntil(...) WB_DELAY_UNTIL_OF(__VA_ARGS__, wb_os_delay_period, wb_os_delay_until, 0)(__VA_ARGS__)

#ifdef __cplusplus
}
#endif
#endif
