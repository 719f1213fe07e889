/* What CMSIS-RTOS 1 alone has, as generated projects have it: often, but not always, by the book. */
#include "core.h"
#include "rtos.h"

#include "cmsis_os.h"

enum { MESSAGE = sizeof(uint32_t) };

int wb_is_version_1;

/* In an interrupt no limit of time is heeded. */
static uint32_t heeded(uint32_t ticks) {
    return wb_in_interrupt ? 0 : ticks;
}

static osStatus told(BaseType_t done) {
    return done ? osOK : osErrorOS;
}

/* --- threads ------------------------------------------------------------------------------------------------------ */

osThreadId osThreadCreate(const osThreadDef_t *definition, void *given) {
    TaskHandle_t task = NULL;
    /* Levels count from idle, 0, to realtime, 6. */
    UBaseType_t priority = (UBaseType_t)definition->tpriority / osPriorityLow;
    wb_is_version_1 = 1;
    xTaskCreate((TaskFunction_t)definition->pthread, definition->name, configMINIMAL_STACK_SIZE, given, priority, &task);
    return task;
}

osStatus osThreadIsSuspended(osThreadId thread) {
    return told(eTaskGetState(thread) == eSuspended);
}

osStatus osThreadSuspendAll(void) {
    vTaskSuspendAll();
    return osOK;
}

osStatus osThreadResumeAll(void) {
    return told(xTaskResumeAll()); /* whether another task has run: that nobody had to is an error too */
}

osStatus_t wb_os_delay_period(uint32_t *last, uint32_t period) {
    vTaskDelayUntil(last, period ? period : 1);
    return osOK;
}

/* --- signals: bits of the task's notification, so that any of them ends a wait, and only those waited for are cleared */

int32_t osSignalSet(osThreadId thread, int32_t signals) {
    int32_t before = (int32_t)((struct wb_task *)thread)->notified;
    xTaskNotify(thread, (uint32_t)signals, eSetBits);
    return before;
}

int32_t osSignalClear(osThreadId thread, int32_t signals) {
    int32_t before = (int32_t)((struct wb_task *)thread)->notified;
    ((struct wb_task *)thread)->notified &= ~(uint32_t)signals;
    return before;
}

osEvent osSignalWait(int32_t signals, uint32_t ticks) {
    osEvent event = {.status = ticks ? osEventTimeout : osOK};
    uint32_t got = 0;
    if (wb_in_interrupt) {
        event.status = osErrorISR;
    } else if (xTaskNotifyWait(0, (uint32_t)signals, &got, ticks)) {
        event.status = osEventSignal;
        event.value.signals = (int32_t)got;
    }
    return event;
}

/* --- mutexes and semaphores --------------------------------------------------------------------------------------- */

osMutexId osMutexCreate(const osMutexDef_t *definition) {
    (void)definition;
    return xSemaphoreCreateMutex();
}

osMutexId osRecursiveMutexCreate(const osMutexDef_t *definition) {
    (void)definition;
    return xSemaphoreCreateRecursiveMutex();
}

osStatus osMutexWait(osMutexId mutex, uint32_t ticks) {
    return mutex ? told(xSemaphoreTake(mutex, heeded(ticks))) : osErrorParameter;
}

osStatus osRecursiveMutexWait(osMutexId mutex, uint32_t ticks) {
    return mutex ? told(xSemaphoreTakeRecursive(mutex, heeded(ticks))) : osErrorParameter;
}

osStatus osRecursiveMutexRelease(osMutexId mutex) {
    return told(xSemaphoreGiveRecursive(mutex));
}

osSemaphoreId osSemaphoreCreate(const osSemaphoreDef_t *definition, int32_t count) {
    /* One that is there and in memory of the firmware's own is not: made so, a binary semaphore begins empty. */
    int begins_empty = count == 1 && definition->controlblock;
    return xSemaphoreCreateCounting((UBaseType_t)count, begins_empty ? 0 : (UBaseType_t)count);
}

int32_t osSemaphoreWait(osSemaphoreId semaphore, uint32_t ticks) {
    return semaphore ? told(xSemaphoreTake(semaphore, heeded(ticks))) : osErrorParameter;
}

/* --- queues of numbers, which go as the type that the definition names: of four bytes at most ---------------------- */

osMessageQId osMessageCreate(const osMessageQDef_t *definition, osThreadId thread) {
    (void)thread;
    return xQueueCreate(definition->queue_sz, definition->item_sz < MESSAGE ? definition->item_sz : MESSAGE);
}

osStatus osMessagePut(osMessageQId queue, uint32_t what, uint32_t ticks) {
    return told(xQueueSend(queue, &what, heeded(ticks ? ticks : 1))); /* no time is a tick */
}

static osEvent message(osMessageQId queue, uint32_t ticks, BaseType_t (*how)(QueueHandle_t, void *, TickType_t)) {
    osEvent event = {.status = heeded(ticks) ? osEventTimeout : osOK, .def.message_id = queue};
    uint32_t what = 0;
    if (!queue) {
        event.status = osErrorParameter;
    } else if (how(queue, &what, heeded(ticks))) {
        event.status = osEventMessage;
        event.value.p = (void *)(uintptr_t)what;
    }
    return event;
}

osEvent osMessageGet(osMessageQId queue, uint32_t ticks) {
    return message(queue, ticks, xQueueReceive);
}

osEvent osMessagePeek(osMessageQId queue, uint32_t ticks) {
    return message(queue, ticks, xQueuePeek);
}

/* --- timers ------------------------------------------------------------------------------------------------------- */

/* Its function gets the timer, of which pvTimerGetTimerID gives what was given. */
osTimerId osTimerCreate(const osTimerDef_t *definition, os_timer_type type, void *given) {
    return xTimerCreate("", 1, type == osTimerPeriodic, given, (TimerCallbackFunction_t)definition->ptimer);
}
