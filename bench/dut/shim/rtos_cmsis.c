/* CMSIS-RTOS in both versions, in the words of the scheduler below it. */
#include "core.h"
#include "rtos.h"

#include "cmsis_os.h"

static osStatus_t told(BaseType_t done, uint32_t ticks) {
    return done ? osOK : ticks ? osErrorTimeout : osErrorResource;
}

/* In an interrupt version 2 refuses a limit of time, even where nothing has to be waited for; version 1 heeds none. */
static int is_refused(uint32_t ticks) {
    return wb_in_interrupt && ticks;
}

static uint32_t heeded(uint32_t ticks) {
    return wb_in_interrupt ? 0 : ticks;
}

/* --- kernel and threads ------------------------------------------------------------------------------------------- */

osStatus_t osKernelInitialize(void) {
    return osOK;
}

osStatus_t osKernelStart(void) {
    vTaskStartScheduler();
    return osOK;
}

uint32_t osKernelGetTickCount(void) {
    return xTaskGetTickCount();
}

osThreadId_t osThreadNew(osThreadFunc_t function, void *given, const osThreadAttr_t *attributes) {
    TaskHandle_t task = NULL;
    UBaseType_t priority = attributes && attributes->priority ? (UBaseType_t)attributes->priority : osPriorityNormal;
    xTaskCreate(function, attributes ? attributes->name : NULL, configMINIMAL_STACK_SIZE, given, priority, &task);
    return task;
}

osThreadId osThreadCreate(const osThreadDef_t *definition, void *given) {
    TaskHandle_t task = NULL;
    /* Version 1 counts its levels from idle, 0, to realtime, 6. */
    UBaseType_t priority = (UBaseType_t)definition->priority / osPriorityLow;
    xTaskCreate((TaskFunction_t)definition->function, definition->name, configMINIMAL_STACK_SIZE, given, priority, &task);
    return task;
}

osThreadId_t osThreadGetId(void) {
    return xTaskGetCurrentTaskHandle();
}

osStatus_t osThreadYield(void) {
    taskYIELD();
    return osOK;
}

osStatus_t osThreadTerminate(osThreadId_t thread) {
    vTaskDelete(thread);
    return osOK;
}

void osThreadExit(void) {
    vTaskDelete(NULL);
}

osStatus_t osThreadSuspend(osThreadId_t thread) {
    vTaskSuspend(thread);
    return osOK;
}

osStatus_t osThreadResume(osThreadId_t thread) {
    vTaskResume(thread);
    return osOK;
}

osStatus_t osDelay(uint32_t ticks) {
    vTaskDelay(ticks);
    return osOK;
}

osStatus_t wb_os_delay_until(uint32_t tick) {
    int32_t ahead = (int32_t)(tick - wb_tick);
    if (ahead <= 0)
        return osErrorParameter;
    vTaskDelay((TickType_t)ahead);
    return osOK;
}

osStatus_t wb_os_delay_period(uint32_t *last, uint32_t period) {
    vTaskDelayUntil(last, period);
    return osOK;
}

/* --- flags and signals -------------------------------------------------------------------------------------------- */

static uint32_t wait_for(struct wb_group *group, uint32_t flags, uint32_t options, uint32_t ticks) {
    int all = (options & osFlagsWaitAll) != 0;
    uint32_t got = xEventGroupWaitBits(group, flags, !(options & osFlagsNoClear), all, ticks);
    if (all ? (got & flags) == flags : (got & flags) != 0)
        return got;
    return ticks ? osFlagsErrorTimeout : osFlagsErrorResource;
}

uint32_t osThreadFlagsSet(osThreadId_t thread, uint32_t flags) {
    return xEventGroupSetBits(&((struct wb_task *)thread)->flags, flags);
}

uint32_t osThreadFlagsClear(uint32_t flags) {
    return xEventGroupClearBits(&wb_rtos_current()->flags, flags);
}

uint32_t osThreadFlagsWait(uint32_t flags, uint32_t options, uint32_t ticks) {
    return wait_for(&wb_rtos_current()->flags, flags, options, ticks);
}

osEventFlagsId_t osEventFlagsNew(const osEventFlagsAttr_t *attributes) {
    (void)attributes;
    return xEventGroupCreate();
}

uint32_t osEventFlagsSet(osEventFlagsId_t group, uint32_t flags) {
    return xEventGroupSetBits(group, flags);
}

uint32_t osEventFlagsClear(osEventFlagsId_t group, uint32_t flags) {
    return xEventGroupClearBits(group, flags);
}

uint32_t osEventFlagsWait(osEventFlagsId_t group, uint32_t flags, uint32_t options, uint32_t ticks) {
    return wait_for(group, flags, options, ticks);
}

/* Version 1 as generated projects have it: a signal is a bit of the task's notification, so that any of them ends a wait,
 * and only those that were waited for are cleared.
 */
int32_t osSignalSet(osThreadId thread, int32_t signals) {
    int32_t before = (int32_t)((struct wb_task *)thread)->notified;
    xTaskNotify(thread, (uint32_t)signals, eSetBits);
    return before;
}

osEvent osSignalWait(int32_t signals, uint32_t ticks) {
    osEvent event = {.status = ticks ? osEventTimeout : osOK};
    uint32_t got = 0;
    if (xTaskNotifyWait(0, (uint32_t)signals, &got, ticks)) {
        event.status = osEventSignal;
        event.value.signals = (int32_t)got;
    }
    return event;
}

/* --- mutexes and semaphores --------------------------------------------------------------------------------------- */

osMutexId_t osMutexNew(const osMutexAttr_t *attributes) {
    SemaphoreHandle_t mutex = xSemaphoreCreateMutex();
    if (mutex)
        mutex->is_recursive = attributes && (attributes->attr_bits & osMutexRecursive);
    return mutex;
}

osMutexId osMutexCreate(const osMutexDef_t *definition) {
    (void)definition;
    return osMutexNew(NULL);
}

osStatus_t osMutexAcquire(osMutexId_t given, uint32_t ticks) {
    SemaphoreHandle_t mutex = given;
    if (wb_in_interrupt)
        return osErrorISR;
    return told(mutex->is_recursive ? xSemaphoreTakeRecursive(mutex, ticks) : xSemaphoreTake(mutex, ticks), ticks);
}

osStatus osMutexWait(osMutexId mutex, uint32_t ticks) {
    return xSemaphoreTake(mutex, heeded(ticks)) ? osOK : osErrorOS;
}

osStatus_t osMutexRelease(osMutexId_t given) {
    SemaphoreHandle_t mutex = given;
    return told(mutex->is_recursive ? xSemaphoreGiveRecursive(mutex) : xSemaphoreGive(mutex), 0);
}

osSemaphoreId_t osSemaphoreNew(uint32_t most, uint32_t first, const osSemaphoreAttr_t *attributes) {
    (void)attributes;
    return xSemaphoreCreateCounting(most, first);
}

osSemaphoreId osSemaphoreCreate(const osSemaphoreDef_t *definition, int32_t count) {
    (void)definition;
    return xSemaphoreCreateCounting((UBaseType_t)count, (UBaseType_t)count);
}

osStatus_t osSemaphoreAcquire(osSemaphoreId_t semaphore, uint32_t ticks) {
    return is_refused(ticks) ? osErrorParameter : told(xSemaphoreTake(semaphore, ticks), ticks);
}

int32_t osSemaphoreWait(osSemaphoreId semaphore, uint32_t ticks) {
    return xSemaphoreTake(semaphore, heeded(ticks)) ? osOK : osErrorOS;
}

osStatus_t osSemaphoreRelease(osSemaphoreId_t semaphore) {
    return told(xSemaphoreGive(semaphore), 0);
}

uint32_t osSemaphoreGetCount(osSemaphoreId_t semaphore) {
    return (uint32_t)uxSemaphoreGetCount(semaphore);
}

/* --- queues ------------------------------------------------------------------------------------------------------- */

osMessageQueueId_t osMessageQueueNew(uint32_t length, uint32_t item_size, const osMessageQueueAttr_t *attributes) {
    (void)attributes;
    return xQueueCreate(length, item_size);
}

osMessageQId osMessageCreate(const osMessageQDef_t *definition, osThreadId thread) {
    (void)thread;
    return xQueueCreate(definition->length, sizeof(uint32_t));
}

osStatus_t osMessageQueuePut(osMessageQueueId_t queue, const void *item, uint8_t priority, uint32_t ticks) {
    (void)priority; /* FreeRTOS leaves it out too */
    return is_refused(ticks) ? osErrorParameter : told(xQueueSend(queue, item, ticks), ticks);
}

osStatus osMessagePut(osMessageQId queue, uint32_t what, uint32_t ticks) {
    return xQueueSend(queue, &what, heeded(ticks)) ? osOK : osErrorOS;
}

osStatus_t osMessageQueueGet(osMessageQueueId_t queue, void *item, uint8_t *priority, uint32_t ticks) {
    if (priority)
        *priority = 0;
    return is_refused(ticks) ? osErrorParameter : told(xQueueReceive(queue, item, ticks), ticks);
}

osEvent osMessageGet(osMessageQId queue, uint32_t ticks) {
    osEvent event = {.status = heeded(ticks) ? osEventTimeout : osOK};
    uint32_t what = 0;
    if (xQueueReceive(queue, &what, heeded(ticks))) {
        event.status = osEventMessage;
        event.value.v = what;
    }
    return event;
}

uint32_t osMessageQueueGetCount(osMessageQueueId_t queue) {
    return (uint32_t)uxQueueMessagesWaiting(queue);
}

osStatus_t osMessageQueueReset(osMessageQueueId_t queue) {
    xQueueReset(queue);
    return osOK;
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

/* Its function gets the timer, of which pvTimerGetTimerID gives what was given: in generated projects, if not by the book. */
osTimerId osTimerCreate(const osTimerDef_t *definition, osTimerType_t type, void *given) {
    return xTimerCreate("", 1, type == osTimerPeriodic, given, (TimerCallbackFunction_t)definition->call);
}

osStatus_t osTimerStart(osTimerId_t timer, uint32_t ticks) {
    return told(xTimerChangePeriod(timer, ticks, 0), 0);
}

osStatus_t osTimerStop(osTimerId_t timer) {
    return told(xTimerStop(timer, 0), 0);
}
