/* A small scheduler: tasks on stacks of their own, the highest priority that is ready runs, equals take turns each tick.
 *
 * It runs in virtual time, so a schedule is the same in every run. An interrupt that wakes a task of higher priority is
 * followed by that task. Interrupts come at the beginning of a tick; a task that computes for longer is interrupted there.
 */
#define _GNU_SOURCE
#include "core.h"

#include "cmsis_os.h"

#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <ucontext.h>

enum { STACK = 256 * 1024, GUARD = 4096, MOST_TASKS = 64, NAME = 16 };
enum state { READY, BLOCKED, DELETED };

struct wb_task {
    ucontext_t context;
    TaskFunction_t function;
    void *given;
    UBaseType_t priority;
    enum state state;
    int is_timed;
    TickType_t wake_tick;
    const void *waits_for;
    uint32_t notified;
    char name[NAME];
};

struct wb_queue {
    UBaseType_t length, item_size, first, count;
    uint8_t *items;
};

static struct wb_task *tasks[MOST_TASKS];
static int task_count, last_run;
static struct wb_task *current;
static ucontext_t idle;
static int is_running, nesting, suspended;

static struct wb_task *pick(void) {
    int best = -1;
    for (int i = 1; i <= task_count; i++) { /* after the last one: equals take turns */
        int which = (last_run + i) % task_count;
        if (tasks[which]->state == READY && (best < 0 || tasks[which]->priority > tasks[best]->priority))
            best = which;
    }
    if (best < 0)
        return NULL;
    last_run = best;
    return tasks[best];
}

/* Let the task run that should; returns when the calling one should again. */
static void reschedule(void) {
    struct wb_task *from = current, *to = pick();
    if (to == from)
        return;
    current = to;
    swapcontext(&from->context, to ? &to->context : &idle);
}

static void block(const void *on, TickType_t ticks) {
    if (wb_in_interrupt)
        wb_fault(WB_FAULT_WAIT_IN_INTERRUPT, "");
    if (!current)
        wb_fault(WB_FAULT_ASSERT, "waits for a queue, semaphore or delay before vTaskStartScheduler");
    current->state = BLOCKED;
    current->waits_for = on;
    current->is_timed = ticks != portMAX_DELAY;
    current->wake_tick = wb_tick + ticks;
    reschedule();
}

static void wake_one(const void *waiting_for) {
    struct wb_task *best = NULL;
    for (int i = 0; i < task_count; i++)
        if (tasks[i]->state == BLOCKED && tasks[i]->waits_for == waiting_for && (!best || tasks[i]->priority > best->priority))
            best = tasks[i];
    if (!best)
        return;
    best->state = READY;
    best->waits_for = NULL;
}

static void preempt(void) {
    if (current && !wb_in_interrupt && !nesting && !suspended)
        for (int i = 0; i < task_count; i++)
            if (tasks[i]->state == READY && tasks[i]->priority > current->priority) {
                reschedule();
                return;
            }
}

void wb_rtos_after_tick(void) {
    if (!is_running)
        return;
    for (int i = 0; i < task_count; i++)
        if (tasks[i]->state == BLOCKED && tasks[i]->is_timed && (int32_t)(wb_tick - tasks[i]->wake_tick) >= 0)
            tasks[i]->state = READY;
    if (current && !suspended)
        reschedule();
}

static void begin(void) {
    struct wb_task *self = current;
    self->function(self->given);
    wb_fault(WB_FAULT_ASSERT, "a task returned; it has to loop for ever or to delete itself");
}

/* --- tasks -------------------------------------------------------------------------------------------------------- */

BaseType_t xTaskCreate(
    TaskFunction_t function, const char *name, configSTACK_DEPTH_TYPE depth, void *given, UBaseType_t priority, TaskHandle_t *handle) {
    (void)depth; /* a host's frames are larger: every task has a quarter of a megabyte */
    struct wb_task *task = calloc(1, sizeof *task);
    char *stack = mmap(NULL, GUARD + STACK, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (!task || stack == MAP_FAILED || task_count == MOST_TASKS)
        return pdFAIL;
    mprotect(stack, GUARD, PROT_NONE);
    task->function = function;
    task->given = given;
    task->priority = priority;
    snprintf(task->name, sizeof task->name, "%s", name ? name : "");
    getcontext(&task->context);
    task->context.uc_stack.ss_sp = stack + GUARD;
    task->context.uc_stack.ss_size = STACK;
    makecontext(&task->context, begin, 0);
    tasks[task_count++] = task;
    if (handle)
        *handle = task;
    preempt();
    return pdPASS;
}

void vTaskDelete(TaskHandle_t task) {
    struct wb_task *gone = task ? task : current;
    gone->state = DELETED;
    if (gone == current)
        reschedule();
}

void vTaskStartScheduler(void) {
    is_running = 1;
    for (;;) {
        current = task_count ? pick() : NULL;
        if (current)
            swapcontext(&idle, &current->context);
        else
            wb_end_tick(); /* everybody waits */
    }
}

void vTaskDelay(TickType_t ticks) {
    if (ticks)
        block(NULL, ticks);
    else
        taskYIELD();
}

BaseType_t xTaskDelayUntil(TickType_t *last, TickType_t period) {
    *last += period;
    int32_t ahead = (int32_t)(*last - wb_tick);
    if (ahead <= 0)
        return pdFALSE;
    block(NULL, (TickType_t)ahead);
    return pdTRUE;
}

TickType_t xTaskGetTickCount(void) {
    wb_poll();
    return wb_tick;
}

TickType_t xTaskGetTickCountFromISR(void) {
    return wb_tick;
}

TaskHandle_t xTaskGetCurrentTaskHandle(void) {
    return current;
}

void taskYIELD(void) {
    if (current)
        reschedule();
}

void taskENTER_CRITICAL(void) {
    nesting++;
    wb_irq_off();
}

void taskEXIT_CRITICAL(void) {
    if (nesting && --nesting == 0) {
        wb_irq_on();
        preempt();
    }
}

void vTaskSuspendAll(void) {
    suspended++;
}

BaseType_t xTaskResumeAll(void) {
    if (suspended && --suspended == 0)
        preempt();
    return pdFALSE;
}

static void notify(TaskHandle_t task) {
    task->notified++;
    if (task->state == BLOCKED && task->waits_for == &task->notified) {
        task->state = READY;
        task->waits_for = NULL;
    }
}

BaseType_t xTaskNotifyGive(TaskHandle_t task) {
    notify(task);
    preempt();
    return pdPASS;
}

void vTaskNotifyGiveFromISR(TaskHandle_t task, BaseType_t *wanted) {
    notify(task);
    if (wanted)
        *wanted = pdTRUE;
}

uint32_t ulTaskNotifyTake(BaseType_t clear, TickType_t ticks) {
    if (current && current->notified == 0 && ticks)
        block(&current->notified, ticks);
    if (!current || current->notified == 0)
        return 0;
    uint32_t count = current->notified;
    current->notified = clear ? 0 : count - 1;
    return count;
}

/* --- queues ------------------------------------------------------------------------------------------------------- */

QueueHandle_t xQueueCreate(UBaseType_t length, UBaseType_t item_size) {
    struct wb_queue *queue = calloc(1, sizeof *queue);
    if (!queue)
        return NULL;
    queue->length = length;
    queue->item_size = item_size;
    queue->items = item_size ? calloc(length, item_size) : NULL;
    return queue;
}

SemaphoreHandle_t xSemaphoreCreateCounting(UBaseType_t most, UBaseType_t first) {
    struct wb_queue *queue = xQueueCreate(most, 0);
    if (queue)
        queue->count = first;
    return queue;
}

static BaseType_t put(QueueHandle_t queue, const void *item) {
    if (queue->count == queue->length)
        return pdFALSE;
    if (queue->item_size)
        memcpy(queue->items + (queue->first + queue->count) % queue->length * queue->item_size, item, queue->item_size);
    queue->count++;
    wake_one(queue);
    return pdTRUE;
}

static BaseType_t take(QueueHandle_t queue, void *item, int keep) {
    if (queue->count == 0)
        return pdFALSE;
    if (queue->item_size)
        memcpy(item, queue->items + queue->first * queue->item_size, queue->item_size);
    if (keep)
        return pdTRUE;
    queue->first = (queue->first + 1) % queue->length;
    queue->count--;
    wake_one(&queue->length); /* whoever waits for room */
    return pdTRUE;
}

BaseType_t xQueueSend(QueueHandle_t queue, const void *item, TickType_t ticks) {
    TickType_t start = wb_tick;
    while (!put(queue, item)) {
        TickType_t passed = wb_tick - start;
        if (passed >= ticks)
            return errQUEUE_FULL;
        block(&queue->length, ticks == portMAX_DELAY ? portMAX_DELAY : ticks - passed);
    }
    preempt();
    return pdTRUE;
}

BaseType_t xQueueSendFromISR(QueueHandle_t queue, const void *item, BaseType_t *wanted) {
    if (wanted)
        *wanted = pdTRUE;
    return put(queue, item);
}

BaseType_t xQueueOverwrite(QueueHandle_t queue, const void *item) {
    queue->count = 0;
    queue->first = 0;
    return put(queue, item);
}

static BaseType_t receive(QueueHandle_t queue, void *item, TickType_t ticks, int keep) {
    TickType_t start = wb_tick;
    while (!take(queue, item, keep)) {
        TickType_t passed = wb_tick - start;
        if (passed >= ticks) {
            wb_poll();
            return errQUEUE_EMPTY;
        }
        block(queue, ticks == portMAX_DELAY ? portMAX_DELAY : ticks - passed);
    }
    preempt();
    return pdTRUE;
}

BaseType_t xQueueReceive(QueueHandle_t queue, void *item, TickType_t ticks) {
    return receive(queue, item, ticks, 0);
}

BaseType_t xQueuePeek(QueueHandle_t queue, void *item, TickType_t ticks) {
    return receive(queue, item, ticks, 1);
}

BaseType_t xQueueReceiveFromISR(QueueHandle_t queue, void *item, BaseType_t *wanted) {
    if (wanted)
        *wanted = pdFALSE;
    return take(queue, item, 0);
}

BaseType_t xQueueReset(QueueHandle_t queue) {
    queue->count = queue->first = 0;
    return pdPASS;
}

UBaseType_t uxQueueMessagesWaiting(QueueHandle_t queue) {
    wb_poll();
    return queue->count;
}

/* --- the rest ----------------------------------------------------------------------------------------------------- */

void wb_rtos_assert(const char *file, int line, const char *truth) {
    char text[200];
    snprintf(text, sizeof text, "configASSERT(%s) failed in %s:%d", truth, file, line);
    wb_fault(WB_FAULT_ASSERT, text);
}

void *pvPortMalloc(size_t size) {
    return malloc(size);
}

void vPortFree(void *given) {
    free(given);
}

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

osStatus_t osDelay(uint32_t ticks) {
    vTaskDelay(ticks);
    return osOK;
}

osStatus_t osDelayUntil(uint32_t ticks) {
    int32_t ahead = (int32_t)(ticks - wb_tick);
    if (ahead > 0)
        vTaskDelay((TickType_t)ahead);
    return osOK;
}
