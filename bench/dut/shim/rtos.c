/* A small scheduler: tasks on stacks of their own, the highest priority that is ready runs, equals take turns each tick.
 *
 * It runs in virtual time, so a schedule is the same in every run. An interrupt that wakes a task of higher priority is
 * followed by that task. Interrupts come at the beginning of a tick; a task that computes for longer is interrupted there.
 */
#define _GNU_SOURCE
#include "core.h"
#include "rtos.h"

#include "semphr.h"

#include <stdio.h>
#include <string.h>
#include <sys/mman.h>

enum { STACK = 256 * 1024, GUARD = 4096 };

struct wb_task *wb_tasks[WB_MOST_TASKS];
int wb_task_count;
static int next_turn[configMAX_PRIORITIES]; /* a priority's tasks take turns, whoever ran between them */
static struct wb_task *current;
static ucontext_t idle;
static int is_running, nesting, suspended;

static struct wb_task *pick(void) {
    UBaseType_t highest = 0;
    for (int i = 0; i < wb_task_count; i++)
        if (wb_tasks[i]->state == WB_READY && wb_tasks[i]->priority > highest)
            highest = wb_tasks[i]->priority;
    for (int i = 0; i < wb_task_count; i++) {
        int which = (next_turn[highest] + i) % wb_task_count;
        if (wb_tasks[which]->state == WB_READY && wb_tasks[which]->priority == highest) {
            next_turn[highest] = which + 1;
            return wb_tasks[which];
        }
    }
    return NULL;
}

/* Let the task run that should; returns when the calling one should again. */
static void reschedule(void) {
    struct wb_task *from = current, *to = pick();
    if (to == from)
        return;
    current = to;
    swapcontext(&from->context, to ? &to->context : &idle);
}

void wb_rtos_block(const void *on, TickType_t ticks) {
    if (wb_in_interrupt)
        wb_fault(WB_FAULT_WAIT_IN_INTERRUPT, "");
    if (!current)
        wb_fault(WB_FAULT_ASSERT, "waits for a queue, semaphore or delay before vTaskStartScheduler");
    current->state = WB_BLOCKED;
    current->waits_for = on;
    current->is_timed = ticks != portMAX_DELAY;
    current->wake_tick = wb_tick + ticks;
    reschedule();
}

void wb_rtos_wake(const void *waiting_for) {
    struct wb_task *best = NULL;
    for (int i = 0; i < wb_task_count; i++)
        if (wb_tasks[i]->state == WB_BLOCKED && wb_tasks[i]->waits_for == waiting_for && (!best || wb_tasks[i]->priority > best->priority))
            best = wb_tasks[i];
    if (best)
        best->state = WB_READY;
}

int wb_rtos_preempt(void) {
    if (current && !wb_in_interrupt && !nesting && !suspended)
        for (int i = 0; i < wb_task_count; i++)
            if (wb_tasks[i]->state == WB_READY && wb_tasks[i]->priority > current->priority) {
                reschedule();
                return 1;
            }
    return 0;
}

void wb_rtos_after_tick(void) {
    if (!is_running)
        return;
    for (int i = 0; i < wb_task_count; i++)
        if (wb_tasks[i]->state == WB_BLOCKED && wb_tasks[i]->is_timed && (int32_t)(wb_tick - wb_tasks[i]->wake_tick) >= 0)
            wb_tasks[i]->state = WB_READY;
    if (current && !suspended)
        reschedule();
}

struct wb_task *wb_rtos_current(void) {
    return current;
}

static void begin(void) {
    struct wb_task *self = current;
    self->function(self->given);
    wb_fault(WB_FAULT_ASSERT, "a task returned; it has to loop for ever or to delete itself");
}

/* --- tasks -------------------------------------------------------------------------------------------------------- */

/* The highest of all stands for what is above it. */
static UBaseType_t possible(UBaseType_t priority) {
    return priority < configMAX_PRIORITIES ? priority : configMAX_PRIORITIES - 1;
}

/* The room of a deleted task, as the idle task gives it back on the chip; its stack stays its own. */
static struct wb_task *freed(void) {
    for (int i = 0; i < wb_task_count; i++) {
        struct wb_task *task = wb_tasks[i];
        if (task->state != WB_DELETED || task == current)
            continue;
        memmove(&wb_tasks[i], &wb_tasks[i + 1], (size_t)(--wb_task_count - i) * sizeof *wb_tasks);
        for (int each = 0; each < configMAX_PRIORITIES; each++)
            next_turn[each] -= next_turn[each] > i; /* whose turn it is stays as it was */
        *task = (struct wb_task){.stack = task->stack};
        return task;
    }
    return NULL;
}

/* Room for one more task; NULL where there is none. */
static struct wb_task *place(void) {
    struct wb_task *task = freed();
    if (task || wb_task_count == WB_MOST_TASKS)
        return task;
    task = calloc(1, sizeof *task);
    char *stack = mmap(NULL, GUARD + STACK, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (!task || stack == MAP_FAILED)
        return NULL;
    mprotect(stack, GUARD, PROT_NONE);
    task->stack = stack + GUARD;
    return task;
}

BaseType_t xTaskCreate(
    TaskFunction_t function, const char *name, configSTACK_DEPTH_TYPE depth, void *given, UBaseType_t priority, TaskHandle_t *handle) {
    (void)depth; /* a host's frames are larger: every task has a quarter of a megabyte */
    struct wb_task *task = place();
    if (!task)
        return pdFAIL;
    task->function = function;
    task->given = given;
    task->priority = possible(priority);
    snprintf(task->name, sizeof task->name, "%s", name ? name : "");
    getcontext(&task->context);
    task->context.uc_stack.ss_sp = task->stack;
    task->context.uc_stack.ss_size = STACK;
    makecontext(&task->context, begin, 0);
    wb_tasks[wb_task_count++] = task;
    if (handle)
        *handle = task;
    wb_rtos_preempt();
    return pdPASS;
}

TaskHandle_t xTaskCreateStatic(
    TaskFunction_t function, const char *name, uint32_t depth, void *given, UBaseType_t priority, StackType_t *stack, StaticTask_t *memory) {
    (void)stack;
    (void)memory;
    TaskHandle_t task = NULL;
    xTaskCreate(function, name, (configSTACK_DEPTH_TYPE)depth, given, priority, &task);
    return task;
}

void vTaskDelete(TaskHandle_t task) {
    struct wb_task *gone = task ? task : current;
    gone->state = WB_DELETED;
    if (gone == current)
        reschedule();
}

void vTaskSuspend(TaskHandle_t task) {
    struct wb_task *which = task ? task : current;
    which->state = WB_SUSPENDED;
    if (which == current)
        reschedule();
}

BaseType_t xTaskResumeFromISR(TaskHandle_t task) {
    if (task->state != WB_SUSPENDED)
        return pdFALSE;
    task->state = WB_READY;
    return pdTRUE;
}

void vTaskResume(TaskHandle_t task) {
    xTaskResumeFromISR(task);
    wb_rtos_preempt();
}

void vTaskPrioritySet(TaskHandle_t task, UBaseType_t priority) {
    (task ? task : current)->priority = possible(priority);
    wb_rtos_preempt();
}

UBaseType_t uxTaskPriorityGet(TaskHandle_t task) {
    return (task ? task : current)->priority;
}

UBaseType_t uxTaskGetStackHighWaterMark(TaskHandle_t task) {
    (void)task;
    return STACK / sizeof(StackType_t); /* a host's stack says nothing of the chip's */
}

UBaseType_t uxTaskGetNumberOfTasks(void) {
    UBaseType_t count = is_running ? 1 : 0; /* the idle task */
    for (int i = 0; i < wb_task_count; i++)
        count += wb_tasks[i]->state != WB_DELETED;
    return count;
}

char *pcTaskGetName(TaskHandle_t task) {
    return (task ? task : current)->name;
}

TaskHandle_t xTaskGetHandle(const char *name) {
    for (int i = 0; i < wb_task_count; i++)
        if (wb_tasks[i]->state != WB_DELETED && strncmp(wb_tasks[i]->name, name, WB_TASK_NAME - 1) == 0)
            return wb_tasks[i];
    return NULL;
}

eTaskState eTaskGetState(TaskHandle_t task) {
    static const eTaskState states[] = {
        [WB_READY] = eReady, [WB_BLOCKED] = eBlocked, [WB_SUSPENDED] = eSuspended, [WB_DELETED] = eDeleted,
    };
    return !task ? eInvalid : task == current ? eRunning : states[task->state];
}

/* A line for each: its name, what it does (X runs, R is ready, B waits, S is suspended), priority, stack, number. */
void vTaskList(char *to) {
    for (int i = 0; i < wb_task_count; i++)
        if (wb_tasks[i]->state != WB_DELETED)
            to += sprintf(to, "%-15s\t%c\t%lu\t%lu\t%d\r\n", wb_tasks[i]->name, "XRBSD"[eTaskGetState(wb_tasks[i])],
                wb_tasks[i]->priority, uxTaskGetStackHighWaterMark(wb_tasks[i]), i + 1);
}

BaseType_t xTaskGetSchedulerState(void) {
    wb_rtos_was_asked = 1;
    if (!is_running)
        return taskSCHEDULER_NOT_STARTED;
    return suspended ? taskSCHEDULER_SUSPENDED : taskSCHEDULER_RUNNING;
}

void vTaskStartScheduler(void) {
    is_running = 1;
    for (;;) {
        current = wb_task_count ? pick() : NULL;
        if (current)
            swapcontext(&idle, &current->context);
        else
            wb_end_tick(); /* everybody waits */
    }
}

void vTaskDelay(TickType_t ticks) {
    if (ticks)
        wb_rtos_block(NULL, ticks);
    else
        taskYIELD();
}

BaseType_t xTaskDelayUntil(TickType_t *last, TickType_t period) {
    *last += period;
    int32_t ahead = (int32_t)(*last - wb_tick);
    if (ahead <= 0)
        return pdFALSE;
    wb_rtos_block(NULL, (TickType_t)ahead);
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
    if (current && !wb_in_interrupt) /* behind an interrupt the scheduler looks in any case */
        reschedule();
}

void taskENTER_CRITICAL(void) {
    nesting++;
    wb_irq_off();
}

void taskEXIT_CRITICAL(void) {
    if (nesting && --nesting == 0) {
        wb_irq_on();
        wb_rtos_preempt();
    }
}

void vTaskSuspendAll(void) {
    suspended++;
}

BaseType_t xTaskResumeAll(void) {
    return suspended && --suspended == 0 && wb_rtos_preempt() ? pdTRUE : pdFALSE;
}

static BaseType_t notify(TaskHandle_t task, uint32_t value, eNotifyAction action) {
    if (action == eSetValueWithoutOverwrite && task->is_notified)
        return pdFAIL;
    if (action == eSetBits)
        task->notified |= value;
    else if (action == eIncrement)
        task->notified++;
    else if (action != eNoAction)
        task->notified = value;
    task->is_notified = 1;
    if (task->state == WB_BLOCKED && task->waits_for == &task->notified)
        task->state = WB_READY;
    return pdPASS;
}

BaseType_t xTaskNotify(TaskHandle_t task, uint32_t value, eNotifyAction action) {
    BaseType_t done = notify(task, value, action);
    wb_rtos_preempt();
    return done;
}

BaseType_t xTaskNotifyFromISR(TaskHandle_t task, uint32_t value, eNotifyAction action, BaseType_t *wanted) {
    if (wanted)
        *wanted = pdTRUE;
    return notify(task, value, action);
}

BaseType_t xTaskNotifyGive(TaskHandle_t task) {
    return xTaskNotify(task, 0, eIncrement);
}

void vTaskNotifyGiveFromISR(TaskHandle_t task, BaseType_t *wanted) {
    xTaskNotifyFromISR(task, 0, eIncrement, wanted);
}

uint32_t ulTaskNotifyTake(BaseType_t clear, TickType_t ticks) {
    if (current && current->notified == 0 && ticks)
        wb_rtos_block(&current->notified, ticks);
    if (!current)
        return 0;
    uint32_t count = current->notified;
    current->is_notified = 0;
    if (count)
        current->notified = clear ? 0 : count - 1;
    return count;
}

BaseType_t xTaskNotifyWait(uint32_t clear_before, uint32_t clear_after, uint32_t *value, TickType_t ticks) {
    if (current && !current->is_notified) {
        current->notified &= ~clear_before;
        if (ticks)
            wb_rtos_block(&current->notified, ticks);
    }
    if (!current)
        return pdFALSE;
    if (value)
        *value = current->notified;
    if (!current->is_notified)
        return pdFALSE;
    current->notified &= ~clear_after;
    current->is_notified = 0;
    return pdTRUE;
}

BaseType_t xTaskNotifyStateClear(TaskHandle_t task) {
    struct wb_task *which = task ? task : current;
    BaseType_t was = which->is_notified ? pdTRUE : pdFALSE;
    which->is_notified = 0;
    return was;
}

uint32_t ulTaskNotifyValueClear(TaskHandle_t task, uint32_t bits) {
    struct wb_task *which = task ? task : current;
    uint32_t was = which->notified;
    which->notified &= ~bits;
    return was;
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

QueueHandle_t xQueueCreateStatic(UBaseType_t length, UBaseType_t item_size, uint8_t *items, StaticQueue_t *memory) {
    (void)items;
    (void)memory;
    return xQueueCreate(length, item_size);
}

void vQueueDelete(QueueHandle_t queue) {
    if (queue)
        free(queue->items);
    free(queue);
}

SemaphoreHandle_t xSemaphoreCreateCounting(UBaseType_t most, UBaseType_t first) {
    struct wb_queue *queue = xQueueCreate(most, 0);
    if (queue)
        queue->count = first;
    return queue;
}

static BaseType_t put(QueueHandle_t queue, const void *item, int in_front) {
    if (queue->count == queue->length)
        return pdFALSE;
    if (in_front)
        queue->first = (queue->first + queue->length - 1) % queue->length;
    UBaseType_t at = in_front ? queue->first : (queue->first + queue->count) % queue->length;
    if (queue->item_size)
        memcpy(queue->items + at * queue->item_size, item, queue->item_size);
    queue->count++;
    wb_rtos_wake(queue);
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
    wb_rtos_wake(&queue->length); /* whoever waits for room */
    return pdTRUE;
}

static BaseType_t send(QueueHandle_t queue, const void *item, TickType_t ticks, int in_front) {
    TickType_t start = wb_tick;
    while (!put(queue, item, in_front)) {
        TickType_t passed = wb_tick - start;
        if (passed >= ticks)
            return errQUEUE_FULL;
        wb_rtos_block(&queue->length, ticks == portMAX_DELAY ? portMAX_DELAY : ticks - passed);
    }
    wb_rtos_preempt();
    return pdTRUE;
}

BaseType_t xQueueSend(QueueHandle_t queue, const void *item, TickType_t ticks) {
    return send(queue, item, ticks, 0);
}

BaseType_t xQueueSendToFront(QueueHandle_t queue, const void *item, TickType_t ticks) {
    return send(queue, item, ticks, 1);
}

BaseType_t xQueueSendFromISR(QueueHandle_t queue, const void *item, BaseType_t *wanted) {
    if (wanted)
        *wanted = pdTRUE;
    return put(queue, item, 0);
}

BaseType_t xQueueSendToFrontFromISR(QueueHandle_t queue, const void *item, BaseType_t *wanted) {
    if (wanted)
        *wanted = pdTRUE;
    return put(queue, item, 1);
}

BaseType_t xQueueOverwrite(QueueHandle_t queue, const void *item) {
    queue->count = queue->first = 0;
    put(queue, item, 0);
    wb_rtos_preempt();
    return pdPASS;
}

static BaseType_t receive(QueueHandle_t queue, void *item, TickType_t ticks, int keep) {
    TickType_t start = wb_tick;
    while (!take(queue, item, keep)) {
        TickType_t passed = wb_tick - start;
        if (passed >= ticks) {
            wb_poll();
            return errQUEUE_EMPTY;
        }
        wb_rtos_block(queue, ticks == portMAX_DELAY ? portMAX_DELAY : ticks - passed);
    }
    wb_rtos_preempt();
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
    wb_rtos_wake(&queue->length);
    wb_rtos_preempt();
    return pdPASS;
}

UBaseType_t uxQueueMessagesWaiting(QueueHandle_t queue) {
    wb_poll();
    return queue->count;
}

UBaseType_t uxQueueSpacesAvailable(QueueHandle_t queue) {
    return queue->length - queue->count;
}

BaseType_t xSemaphoreTakeRecursive(SemaphoreHandle_t mutex, TickType_t ticks) {
    if (mutex->owner != current || !mutex->depth) {
        if (!xSemaphoreTake(mutex, ticks))
            return pdFALSE;
        mutex->owner = current;
    }
    mutex->depth++;
    return pdTRUE;
}

BaseType_t xSemaphoreGiveRecursive(SemaphoreHandle_t mutex) {
    if (mutex->owner != current || !mutex->depth)
        return pdFALSE;
    return --mutex->depth ? pdTRUE : xSemaphoreGive(mutex);
}

/* --- the rest ----------------------------------------------------------------------------------------------------- */

void wb_rtos_assert(const char *file, int line, const char *truth) {
    char text[200];
    snprintf(text, sizeof text, "configASSERT(%s) failed in %s:%d", truth, file, line);
    wb_fault(WB_FAULT_ASSERT, text);
}

/* What a generator's SysTick_Handler calls: the bench tells the scheduler of ticks itself. */
int wb_rtos_was_asked;

void xPortSysTickHandler(void) {
    wb_rtos_was_asked = 1;
}

void osSystickHandler(void);
void osSystickHandler(void) {
    xPortSysTickHandler();
}

void *pvPortMalloc(size_t size) {
    return malloc(size);
}

void vPortFree(void *given) {
    free(given);
}

size_t xPortGetFreeHeapSize(void) {
    return 64 * 1024;
}

BaseType_t xPortIsInsideInterrupt(void) {
    return wb_in_interrupt ? pdTRUE : pdFALSE;
}
