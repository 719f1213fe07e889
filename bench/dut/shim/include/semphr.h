/* Semaphores and mutexes, as queues of nothing; see FreeRTOS.h. Mutexes do not lend priority. */
#ifndef INC_SEMPHR_H
#define INC_SEMPHR_H

#include "queue.h"

#ifdef __cplusplus
extern "C" {
#endif

SemaphoreHandle_t xSemaphoreCreateCounting(UBaseType_t most, UBaseType_t first);
#define xSemaphoreCreateBinary() xSemaphoreCreateCounting(1, 0)
#define vSemaphoreCreateBinary(semaphore) ((semaphore) = xSemaphoreCreateCounting(1, 1)) /* unlike the newer one: it is there */
#define xSemaphoreCreateMutex() xSemaphoreCreateCounting(1, 1)
#define xSemaphoreCreateBinaryStatic(memory) ((void)(memory), xSemaphoreCreateBinary())
#define xSemaphoreCreateMutexStatic(memory) ((void)(memory), xSemaphoreCreateMutex())
#define xSemaphoreCreateCountingStatic(most, first, memory) ((void)(memory), xSemaphoreCreateCounting(most, first))
#define xSemaphoreCreateRecursiveMutex() xSemaphoreCreateMutex()
#define xSemaphoreCreateRecursiveMutexStatic(memory) xSemaphoreCreateMutexStatic(memory)
BaseType_t xSemaphoreTakeRecursive(SemaphoreHandle_t mutex, TickType_t ticks);
BaseType_t xSemaphoreGiveRecursive(SemaphoreHandle_t mutex);
#define vSemaphoreDelete(semaphore) vQueueDelete(semaphore)
#define uxSemaphoreGetCount(semaphore) uxQueueMessagesWaiting(semaphore)
#define xSemaphoreTakeFromISR(semaphore, wanted) xQueueReceiveFromISR(semaphore, NULL, wanted)
#define xSemaphoreTake(semaphore, ticks) xQueueReceive(semaphore, NULL, ticks)
#define xSemaphoreGive(semaphore) xQueueSend(semaphore, NULL, 0)
#define xSemaphoreGiveFromISR(semaphore, wanted) xQueueSendFromISR(semaphore, NULL, wanted)

#ifdef __cplusplus
}
#endif
#endif
