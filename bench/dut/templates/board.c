/* What your board's files do on the robot and the bench need not: clocks, pins, the set-up that a generator wrote.
 *
 * Each of these is taken only where no source of yours has one of that name. The HAL's own calls are the bench's:
 * wheelbench_hal.h lists them; so are a scheduler's, in FreeRTOS.h, task.h, queue.h, semphr.h and cmsis_os.h. What else
 * the linker misses has its place here.
 */
#include "wheelbench_hal.h"

__weak void SystemClock_Config(void) {}
__weak void MX_GPIO_Init(void) {}
__weak void MX_DMA_Init(void) {}
__weak void MX_CAN_Init(void) {}
__weak void MX_CAN1_Init(void) {}
__weak void MX_CAN2_Init(void) {}
__weak void MX_FDCAN1_Init(void) {}
__weak void MX_FDCAN2_Init(void) {}
__weak void MX_USART1_UART_Init(void) {}
__weak void MX_USART2_UART_Init(void) {}
__weak void MX_USART3_UART_Init(void) {}
__weak void MX_UART4_Init(void) {}
__weak void MX_UART5_Init(void) {}
__weak void MX_USART6_UART_Init(void) {}
__weak void MX_TIM2_Init(void) {}
__weak void MX_TIM3_Init(void) {}
__weak void MX_TIM6_Init(void) {}
__weak void MX_TIM7_Init(void) {}
__weak void MX_IWDG_Init(void) {}
