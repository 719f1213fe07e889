/* CMSIS-RTOS 2, and what both versions have, in the words of the scheduler below it. */
#include "core.h"
#include "rtos.h"

#include "cmsis_os.h"

extern uint32_t SystemCoreClock;
static int is_initialised;

static osStatus_t told(BaseType_t done, uint32_t ticks) {
    return done ? osOK : ticks ? osErrorTimeout : osErrorResource;
}

/* In an interrupt version 2 refuses a limit of time, even where nothing has to be waited for. */
static int is_refused(uint32_t ticks) {
    return wb_in_interrupt && ticks;
}

/* Whether it is none of an interrupt's, or of nothing: version 2 asks, version 1 does not. */
static osStatus_t asked(const void *of_what) {
    return wb_is_version_1 ? osOK : wb_in_interrupt ? osErrorISR : of_what ? osOK : osErrorParameter;
}

/* --- kernel and threads ------------------------------------------------------------------------------------------- */

osStatus_t osKernelInitialize(void) {
    is_initialised = 1;
    return osOK;
}

osStatus_t osKernelStart(void) {
    vTaskStartScheduler();
    return osOK;
}

osKernelState_t osKernelGetState(void) {
    BaseType_t state = xTaskGetSchedulerState();
    if (state == taskSCHEDULER_NOT_STARTED)
        return is_initialised ? osKernelReady : osKernelInactive;
    return state == taskSCHEDULER_RUNNING ? osKernelRunning : osKernelLocked;
}

/* What the lock was; then it is as asked for. */
int32_t osKernelRestoreLock(int32_t lock) {
    osKernelState_t state = osKernelGetState();
    if (wb_in_interrupt)
        return osErrorISR;
    if (state < osKernelRunning)
        return osError;
    if (lock && state == osKernelRunning)
        vTaskSuspendAll();
    else if (!lock && state == osKernelLocked)
        xTaskResumeAll();
    return lock;
}

int32_t osKernelLock(void) {
    int32_t was = osKernelGetState() == osKernelLocked, done = osKernelRestoreLock(1);
    return done < 0 ? done : was;
}

int32_t osKernelUnlock(void) {
    int32_t was = osKernelGetState() == osKernelLocked, done = osKernelRestoreLock(0);
    return done < 0 ? done : was;
}

uint32_t osKernelGetTickCount(void) {
    return xTaskGetTickCount();
}

uint32_t osKernelGetSysTimerFreq(void) {
    return SystemCoreClock;
}

uint32_t osKernelGetSysTimerCount(void) {
    wb_poll();
    return wb_share_of_time(SystemCoreClock / configTICK_RATE_HZ);
}

osThreadId_t osThreadNew(osThreadFunc_t function, void *given, const osThreadAttr_t *attributes) {
    TaskHandle_t task = NULL;
    UBaseType_t priority = attributes && attributes->priority ? (UBaseType_t)attributes->priority : osPriorityNormal;
    xTaskCreate(function, attributes ? attributes->name : NULL, configMINIMAL_STACK_SIZE, given, priority, &task);
    return task;
}

osThreadId_t osThreadGetId(void) {
    return xTaskGetCurrentTaskHandle();
}

const char *osThreadGetName(osThreadId_t thread) {
    return thread ? pcTaskGetName(thread) : NULL;
}

uint32_t osThreadGetCount(void) {
    return (uint32_t)uxTaskGetNumberOfTasks();
}

uint32_t osThreadGetStackSpace(osThreadId_t thread) {
    return thread ? (uint32_t)(uxTaskGetStackHighWaterMark(thread) * sizeof(StackType_t)) : 0;
}

osThreadState_t osThreadGetState(osThreadId_t thread) {
    static const osThreadState_t states[] = {
        [eRunning] = osThreadRunning, [eReady] = osThreadReady, [eBlocked] = osThreadBlocked,
        [eSuspended] = osThreadBlocked, [eDeleted] = osThreadTerminated, [eInvalid] = osThreadError,
    };
    eTaskState state = eTaskGetState(thread);
    return wb_is_version_1 && state == eSuspended ? osThreadSuspended : states[state];
}

osStatus_t osThreadYield(void) {
    taskYIELD();
    return osOK;
}

/* Version 1 takes nobody for the one that calls. */
osStatus_t osThreadTerminate(osThreadId_t thread) {
    if (asked(thread) == osOK)
        vTaskDelete(thread);
    return asked(thread);
}

void osThreadExit(void) {
    vTaskDelete(NULL);
}

osStatus_t osThreadSuspend(osThreadId_t thread) {
    if (asked(thread) == osOK)
        vTaskSuspend(thread);
    return asked(thread);
}

osStatus_t osThreadResume(osThreadId_t thread) {
    if (asked(thread) == osOK)
        vTaskResume(thread);
    return asked(thread);
}

/* Levels of version 1 count from idle, 0, to realtime, 6. */
osStatus_t osThreadSetPriority(osThreadId_t thread, osPriority_t priority) {
    if (asked(thread) == osOK)
        vTaskPrioritySet(thread, (UBaseType_t)priority / (wb_is_version_1 ? osPriorityLow : 1));
    return asked(thread);
}

osPriority_t osThreadGetPriority(osThreadId_t thread) {
    if (asked(thread) != osOK)
        return osPriorityError;
    UBaseType_t priority = uxTaskPriorityGet(thread);
    if (!wb_is_version_1)
        return (osPriority_t)priority;
    return priority ? (osPriority_t)(priority * osPriorityLow) : osPriorityIdle;
}

osStatus_t osDelay(uint32_t ticks) {
    if (ticks || wb_is_version_1) /* which delays for a tick at least */
        vTaskDelay(ticks ? ticks : 1);
    return osOK;
}

osStatus_t wb_os_delay_until(uint32_t tick) {
    int32_t ahead = (int32_t)(tick - wb_tick);
    if (ahead <= 0)
        return osErrorParameter;
    vTaskDelay((TickType_t)ahead);
    return osOK;
}

/* --- flags -------------------------------------------------------------------------------------------------------- */

static uint32_t wait_for(struct wb_group *group, uint32_t flags, uint32_t options, uint32_t ticks) {
    if (wb_in_interrupt)
        return osFlagsErrorISR;
    int all = (options & osFlagsWaitAll) != 0;
    uint32_t got = xEventGroupWaitBits(group, flags, !(options & osFlagsNoClear), all, ticks);
    if (all ? (got & flags) == flags : (got & flags) != 0)
        return got;
    return ticks ? osFlagsErrorTimeout : osFlagsErrorResource;
}

uint32_t osThreadFlagsSet(osThreadId_t thread, uint32_t flags) {
    return thread ? xEventGroupSetBits(&((struct wb_task *)thread)->flags, flags) : osFlagsErrorParameter;
}

uint32_t osThreadFlagsClear(uint32_t flags) {
    return xEventGroupClearBits(&wb_rtos_current()->flags, flags);
}

uint32_t osThreadFlagsGet(void) {
    return wb_rtos_current()->flags.bits;
}

uint32_t osThreadFlagsWait(uint32_t flags, uint32_t options, uint32_t ticks) {
    return wait_for(&wb_rtos_current()->flags, flags, options, ticks);
}

osEventFlagsId_t osEventFlagsNew(const osEventFlagsAttr_t *attributes) {
    (void)attributes;
    return xEventGroupCreate();
}

uint32_t osEventFlagsSet(osEventFlagsId_t group, uint32_t flags) {
    return group ? xEventGroupSetBits(group, flags) : osFlagsErrorParameter;
}

uint32_t osEventFlagsClear(osEventFlagsId_t group, uint32_t flags) {
    return group ? xEventGroupClearBits(group, flags) : osFlagsErrorParameter;
}

uint32_t osEventFlagsWait(osEventFlagsId_t group, uint32_t flags, uint32_t options, uint32_t ticks) {
    return group ? wait_for(group, flags, options, ticks) : osFlagsErrorParameter;
}

uint32_t osEventFlagsGet(osEventFlagsId_t group) {
    return group ? xEventGroupGetBits(group) : 0;
}

osStatus_t osEventFlagsDelete(osEventFlagsId_t group) {
    if (asked(group) == osOK)
        vEventGroupDelete(group);
    return asked(group);
}

/* --- mutexes and semaphores --------------------------------------------------------------------------------------- */

osMutexId_t osMutexNew(const osMutexAttr_t *attributes) {
    SemaphoreHandle_t mutex = xSemaphoreCreateMutex();
    if (mutex)
        mutex->is_recursive = attributes && (attributes->attr_bits & osMutexRecursive);
    return mutex;
}

osStatus_t osMutexAcquire(osMutexId_t given, uint32_t ticks) {
    SemaphoreHandle_t mutex = given;
    if (wb_in_interrupt || !mutex)
        return mutex ? osErrorISR : osErrorParameter;
    return told(mutex->is_recursive ? xSemaphoreTakeRecursive(mutex, ticks) : xSemaphoreTake(mutex, ticks), ticks);
}

osStatus_t osMutexRelease(osMutexId_t given) {
    SemaphoreHandle_t mutex = given;
    if (asked(mutex) != osOK)
        return asked(mutex);
    return told(mutex->is_recursive ? xSemaphoreGiveRecursive(mutex) : xSemaphoreGive(mutex), 0);
}

osStatus_t osMutexDelete(osMutexId_t mutex) {
    return osSemaphoreDelete(mutex);
}

osSemaphoreId_t osSemaphoreNew(uint32_t most, uint32_t first, const osSemaphoreAttr_t *attributes) {
    (void)attributes;
    return xSemaphoreCreateCounting(most, first);
}

osStatus_t osSemaphoreAcquire(osSemaphoreId_t semaphore, uint32_t ticks) {
    return !semaphore || is_refused(ticks) ? osErrorParameter : told(xSemaphoreTake(semaphore, ticks), ticks);
}

osStatus_t osSemaphoreRelease(osSemaphoreId_t semaphore) {
    return semaphore ? told(xSemaphoreGive(semaphore), 0) : osErrorParameter;
}

uint32_t osSemaphoreGetCount(osSemaphoreId_t semaphore) {
    return semaphore ? (uint32_t)uxSemaphoreGetCount(semaphore) : 0;
}

osStatus_t osSemaphoreDelete(osSemaphoreId_t semaphore) {
    if (wb_in_interrupt || !semaphore)
        return semaphore ? osErrorISR : osErrorParameter;
    vSemaphoreDelete(semaphore);
    return osOK;
}

/* --- queues ------------------------------------------------------------------------------------------------------- */

osMessageQueueId_t osMessageQueueNew(uint32_t length, uint32_t item_size, const osMessageQueueAttr_t *attributes) {
    (void)attributes;
    return xQueueCreate(length, item_size);
}

osStatus_t osMessageQueuePut(osMessageQueueId_t queue, const void *item, uint8_t priority, uint32_t ticks) {
    (void)priority; /* FreeRTOS leaves it out too */
    return !queue || !item || is_refused(ticks) ? osErrorParameter : told(xQueueSend(queue, item, ticks), ticks);
}

osStatus_t osMessageQueueGet(osMessageQueueId_t queue, void *item, uint8_t *priority, uint32_t ticks) {
    if (priority)
        *priority = 0;
    return !queue || !item || is_refused(ticks) ? osErrorParameter : told(xQueueReceive(queue, item, ticks), ticks);
}

uint32_t osMessageQueueGetCapacity(osMessageQueueId_t queue) {
    return queue ? (uint32_t)((QueueHandle_t)queue)->length : 0;
}

uint32_t osMessageQueueGetMsgSize(osMessageQueueId_t queue) {
    return queue ? (uint32_t)((QueueHandle_t)queue)->item_size : 0;
}

uint32_t osMessageQueueGetCount(osMessageQueueId_t queue) {
    return queue ? (uint32_t)uxQueueMessagesWaiting(queue) : 0;
}

uint32_t osMessageQueueGetSpace(osMessageQueueId_t queue) {
    return queue ? (uint32_t)uxQueueSpacesAvailable(queue) : 0;
}

osStatus_t osMessageQueueReset(osMessageQueueId_t queue) {
    if (asked(queue) == osOK)
        xQueueReset(queue);
    return asked(queue);
}

osStatus_t osMessageQueueDelete(osMessageQueueId_t queue) {
    return osSemaphoreDelete(queue);
}

/* --- timers ------------------------------------------------------------------------------------------------------- */

struct os_timer {
    osTimerFunc_t call;
    void *given;
};

static void call_of(TimerHandle_t timer) {
    struct os_timer *self = pvTimerGetTimerID(timer);
    self->call(self->given);
}

osTimerId_t osTimerNew(osTimerFunc_t call, osTimerType_t type, void *given, const osTimerAttr_t *attributes) {
    (void)attributes;
    struct os_timer *self = calloc(1, sizeof *self);
    if (!self)
        return NULL;
    self->call = call;
    self->given = given;
    return xTimerCreate("", 1, type == osTimerPeriodic, self, call_of);
}

uint32_t osTimerIsRunning(osTimerId_t timer) {
    return timer && xTimerIsTimerActive(timer);
}

osStatus_t osTimerStart(osTimerId_t timer, uint32_t ticks) {
    if (asked(timer) != osOK)
        return asked(timer);
    return told(xTimerChangePeriod(timer, wb_is_version_1 && !ticks ? 1 : ticks, 0), 0);
}

osStatus_t osTimerStop(osTimerId_t timer) {
    if (asked(timer) != osOK)
        return asked(timer);
    if (!wb_is_version_1 && !xTimerIsTimerActive(timer))
        return osErrorResource;
    return told(xTimerStop(timer, 0), 0);
}

osStatus_t osTimerDelete(osTimerId_t timer) {
    return asked(timer) == osOK ? told(xTimerDelete(timer, 0), 0) : asked(timer);
}
