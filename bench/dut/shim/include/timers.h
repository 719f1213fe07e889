/* Software timers; rtos_events.c has them. Written from the interface's public documentation; nothing is copied from it. MIT licence. */
#ifndef TIMERS_H
#define TIMERS_H

#include "FreeRTOS.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct wb_timer *TimerHandle_t;
typedef TimerHandle_t xTimerHandle;
typedef void (*TimerCallbackFunction_t)(TimerHandle_t timer);

TimerHandle_t xTimerCreate(const char *name, TickType_t period, BaseType_t again, void *id, TimerCallbackFunction_t call);
#define xTimerCreateStatic(name, period, again, id, call, memory) ((void)(memory), xTimerCreate(name, period, again, id, call))
BaseType_t xTimerStart(TimerHandle_t timer, TickType_t ticks);
BaseType_t xTimerStop(TimerHandle_t timer, TickType_t ticks);
BaseType_t xTimerReset(TimerHandle_t timer, TickType_t ticks);
BaseType_t xTimerChangePeriod(TimerHandle_t timer, TickType_t period, TickType_t ticks);
BaseType_t xTimerDelete(TimerHandle_t timer, TickType_t ticks);
#define xTimerStartFromISR(timer, wanted) ((void)(wanted), xTimerStart(timer, 0))
#define xTimerStopFromISR(timer, wanted) ((void)(wanted), xTimerStop(timer, 0))
#define xTimerResetFromISR(timer, wanted) ((void)(wanted), xTimerReset(timer, 0))
BaseType_t xTimerIsTimerActive(TimerHandle_t timer);
#define xTimerChangePeriodFromISR(timer, period, wanted) ((void)(wanted), xTimerChangePeriod(timer, period, 0))
void *pvTimerGetTimerID(TimerHandle_t timer);
void vTimerSetTimerID(TimerHandle_t timer, void *id);
TickType_t xTimerGetPeriod(TimerHandle_t timer);

#ifdef __cplusplus
}
#endif
#endif
