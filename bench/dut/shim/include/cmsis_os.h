/* CMSIS-RTOS v2 as generated projects use it, on the same scheduler; see FreeRTOS.h. MIT licence. */
#ifndef CMSIS_OS_H_
#define CMSIS_OS_H_

#include "FreeRTOS.h"
#include "queue.h"
#include "semphr.h"
#include "task.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { osOK = 0, osError = -1, osErrorTimeout = -2, osErrorResource = -3 } osStatus_t;
typedef enum {
    osPriorityNone = 0, osPriorityIdle = 1, osPriorityLow = 8, osPriorityBelowNormal = 16, osPriorityNormal = 24,
    osPriorityAboveNormal = 32, osPriorityHigh = 40, osPriorityRealtime = 48
} osPriority_t;
typedef void *osThreadId_t;
typedef void (*osThreadFunc_t)(void *);
typedef struct {
    const char *name;
    uint32_t attr_bits;
    void *cb_mem;
    uint32_t cb_size;
    void *stack_mem;
    uint32_t stack_size;
    osPriority_t priority;
} osThreadAttr_t;
#define osWaitForever 0xFFFFFFFFU

osStatus_t osKernelInitialize(void);
osStatus_t osKernelStart(void);
uint32_t osKernelGetTickCount(void);
osThreadId_t osThreadNew(osThreadFunc_t function, void *given, const osThreadAttr_t *attributes);
osStatus_t osDelay(uint32_t ticks);
osStatus_t osDelayUntil(uint32_t ticks);

#ifdef __cplusplus
}
#endif
#endif
