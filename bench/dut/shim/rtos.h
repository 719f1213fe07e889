/* Between the scheduler (rtos.c) and what is built on it: rtos_events.c, rtos_cmsis.c. */
#ifndef WB_RTOS_H
#define WB_RTOS_H

#include "FreeRTOS.h"
#include "event_groups.h"
#include "task.h"

#include <ucontext.h>

enum { WB_MOST_TASKS = 64, WB_TASK_NAME = 16 };
enum wb_task_state { WB_READY, WB_BLOCKED, WB_SUSPENDED, WB_DELETED };

struct wb_group {
    EventBits_t bits;
};

struct wb_queue {
    UBaseType_t length, item_size, first, count;
    uint8_t *items;
    int is_recursive; /* a mutex of CMSIS-RTOS that asks for it */
    struct wb_task *owner; /* of a recursive mutex, and how often it has it */
    int depth;
};

struct wb_task {
    ucontext_t context;
    char *stack;
    TaskFunction_t function;
    void *given;
    UBaseType_t priority;
    enum wb_task_state state;
    int is_timed;
    TickType_t wake_tick;
    const void *waits_for; /* while it is blocked */
    uint32_t notified; /* the notification's value */
    int is_notified;
    EventBits_t wanted, got; /* of the group that it waits for; nothing is wanted once it has been served */
    int wants_all, clears;
    struct wb_group flags; /* of CMSIS-RTOS */
    char name[WB_TASK_NAME];
};

extern struct wb_task *wb_tasks[WB_MOST_TASKS];
extern int wb_task_count;

/* Wait on something for so long; ends the run where nobody may wait. */
void wb_rtos_block(const void *on, TickType_t ticks);
/* The task of the highest priority that waits on it is ready. */
void wb_rtos_wake(const void *waiting_for);
/* Let a task run that is ready and of higher priority than this one; whether there was one. */
int wb_rtos_preempt(void);
struct wb_task *wb_rtos_current(void);
extern int wb_is_version_1; /* the firmware makes its tasks as CMSIS-RTOS 1 does, whose calls of the same name differ */

#endif
