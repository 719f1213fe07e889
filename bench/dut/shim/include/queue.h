/* Queues; see FreeRTOS.h. */
#ifndef INC_QUEUE_H
#define INC_QUEUE_H

#include "FreeRTOS.h"

#ifdef __cplusplus
extern "C" {
#endif

QueueHandle_t xQueueCreate(UBaseType_t length, UBaseType_t item_size);
QueueHandle_t xQueueCreateStatic(UBaseType_t length, UBaseType_t item_size, uint8_t *items, StaticQueue_t *memory);
void vQueueDelete(QueueHandle_t queue);
BaseType_t xQueueSend(QueueHandle_t queue, const void *item, TickType_t ticks);
#define xQueueSendToBack(queue, item, ticks) xQueueSend(queue, item, ticks)
BaseType_t xQueueSendFromISR(QueueHandle_t queue, const void *item, BaseType_t *wanted);
#define xQueueSendToBackFromISR(queue, item, wanted) xQueueSendFromISR(queue, item, wanted)
BaseType_t xQueueSendToFront(QueueHandle_t queue, const void *item, TickType_t ticks);
BaseType_t xQueueSendToFrontFromISR(QueueHandle_t queue, const void *item, BaseType_t *wanted);
BaseType_t xQueueOverwrite(QueueHandle_t queue, const void *item);
#define xQueueOverwriteFromISR(queue, item, wanted) xQueueOverwrite(queue, item)
BaseType_t xQueueReceive(QueueHandle_t queue, void *item, TickType_t ticks);
BaseType_t xQueueReceiveFromISR(QueueHandle_t queue, void *item, BaseType_t *wanted);
BaseType_t xQueuePeek(QueueHandle_t queue, void *item, TickType_t ticks);
#define xQueuePeekFromISR(queue, item) xQueuePeek(queue, item, 0)
BaseType_t xQueueReset(QueueHandle_t queue);
UBaseType_t uxQueueMessagesWaiting(QueueHandle_t queue);
UBaseType_t uxQueueSpacesAvailable(QueueHandle_t queue);
#define uxQueueMessagesWaitingFromISR(queue) uxQueueMessagesWaiting(queue)

#ifdef __cplusplus
}
#endif
#endif
