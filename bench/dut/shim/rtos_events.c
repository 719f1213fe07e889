/* Event groups and software timers, on the scheduler of rtos.c. */
#include "core.h"
#include "rtos.h"

#include "timers.h"

#include <string.h>

/* --- event groups: who waits for bits is served when they are set ------------------------------------------------- */

EventGroupHandle_t xEventGroupCreate(void) {
    return calloc(1, sizeof(struct wb_group));
}

void vEventGroupDelete(EventGroupHandle_t group) {
    free(group);
}

static int is_met(EventBits_t bits, EventBits_t wanted, int all) {
    return all ? (bits & wanted) == wanted : (bits & wanted) != 0;
}

static EventBits_t set(EventGroupHandle_t group, EventBits_t bits) {
    EventBits_t taken = 0;
    group->bits |= bits;
    for (int i = 0; i < wb_task_count; i++) {
        struct wb_task *task = wb_tasks[i];
        if (task->state != WB_BLOCKED || task->waits_for != group || !is_met(group->bits, task->wanted, task->wants_all))
            continue;
        task->got = group->bits;
        taken |= task->clears ? task->wanted : 0;
        task->wanted = 0;
        task->state = WB_READY;
    }
    group->bits &= ~taken; /* once all have been served */
    return group->bits;
}

EventBits_t xEventGroupSetBits(EventGroupHandle_t group, EventBits_t bits) {
    EventBits_t now = set(group, bits);
    wb_rtos_preempt();
    return now;
}

BaseType_t xEventGroupSetBitsFromISR(EventGroupHandle_t group, EventBits_t bits, BaseType_t *wanted) {
    if (wanted)
        *wanted = pdTRUE;
    set(group, bits);
    return pdPASS;
}

EventBits_t xEventGroupClearBits(EventGroupHandle_t group, EventBits_t bits) {
    EventBits_t before = group->bits;
    group->bits &= ~bits;
    return before;
}

EventBits_t xEventGroupWaitBits(EventGroupHandle_t group, EventBits_t bits, BaseType_t clear, BaseType_t all, TickType_t ticks) {
    struct wb_task *self = wb_rtos_current();
    EventBits_t now = group->bits;
    if (is_met(now, bits, all != pdFALSE)) {
        group->bits &= clear ? ~bits : ~0U;
        return now;
    }
    if (!ticks || !self) {
        wb_poll();
        return now;
    }
    self->wanted = bits;
    self->wants_all = all != pdFALSE;
    self->clears = clear != pdFALSE;
    wb_rtos_block(group, ticks);
    if (!self->wanted)
        return self->got;
    self->wanted = 0;
    return group->bits;
}

/* --- software timers: their callbacks run in a task of their own -------------------------------------------------- */

enum { MOST_TIMERS = 64, TIMER_PRIORITY = 2 };

struct wb_timer {
    TickType_t period, due;
    int is_active, again, is_deleted;
    void *id;
    TimerCallbackFunction_t call;
};

static struct wb_timer *timers[MOST_TIMERS];
static int timer_count;

static struct wb_timer *earliest(void) {
    struct wb_timer *first = NULL;
    for (int i = 0; i < timer_count; i++)
        if (timers[i]->is_active && (!first || (int32_t)(timers[i]->due - first->due) < 0))
            first = timers[i];
    return first;
}

static void serve(void *unused) {
    (void)unused;
    for (;;) {
        struct wb_timer *next = earliest();
        int32_t left = next ? (int32_t)(next->due - wb_tick) : 0;
        if (!next || left > 0) {
            wb_rtos_block(&timers, next ? (TickType_t)left : portMAX_DELAY);
            continue;
        }
        next->is_active = next->again;
        next->due += next->period;
        next->call(next);
    }
}

/* Room for one more timer, behind the others: that of a deleted one, where there is any. */
static struct wb_timer *place(void) {
    struct wb_timer *timer = NULL;
    for (int i = 0; i < timer_count && !timer; i++)
        if (timers[i]->is_deleted) {
            timer = timers[i];
            memmove(&timers[i], &timers[i + 1], (size_t)(--timer_count - i) * sizeof *timers);
        }
    if (!timer && timer_count < MOST_TIMERS)
        timer = calloc(1, sizeof *timer);
    if (timer)
        timers[timer_count++] = timer;
    return timer;
}

TimerHandle_t xTimerCreate(const char *name, TickType_t period, BaseType_t again, void *id, TimerCallbackFunction_t call) {
    (void)name;
    if (!period)
        return NULL;
    if (!timer_count)
        xTaskCreate(serve, "Tmr Svc", configMINIMAL_STACK_SIZE, NULL, TIMER_PRIORITY, NULL);
    struct wb_timer *timer = place();
    if (timer)
        *timer = (struct wb_timer){.period = period, .again = again != pdFALSE, .id = id, .call = call};
    return timer;
}

static BaseType_t command(TimerHandle_t timer, int is_active) {
    timer->is_active = is_active;
    timer->due = wb_tick + timer->period;
    wb_rtos_wake(&timers);
    wb_rtos_preempt();
    return pdPASS;
}

BaseType_t xTimerStart(TimerHandle_t timer, TickType_t ticks) {
    (void)ticks;
    return command(timer, 1);
}

BaseType_t xTimerReset(TimerHandle_t timer, TickType_t ticks) {
    return xTimerStart(timer, ticks);
}

BaseType_t xTimerStop(TimerHandle_t timer, TickType_t ticks) {
    (void)ticks;
    return command(timer, 0);
}

BaseType_t xTimerDelete(TimerHandle_t timer, TickType_t ticks) {
    timer->is_deleted = 1;
    return xTimerStop(timer, ticks);
}

BaseType_t xTimerChangePeriod(TimerHandle_t timer, TickType_t period, TickType_t ticks) {
    if (!period)
        return pdFAIL;
    timer->period = period;
    return xTimerStart(timer, ticks);
}

BaseType_t xTimerIsTimerActive(TimerHandle_t timer) {
    return timer->is_active ? pdTRUE : pdFALSE;
}

void *pvTimerGetTimerID(TimerHandle_t timer) {
    return timer->id;
}

void vTimerSetTimerID(TimerHandle_t timer, void *id) {
    timer->id = id;
}

TickType_t xTimerGetPeriod(TimerHandle_t timer) {
    return timer->period;
}
