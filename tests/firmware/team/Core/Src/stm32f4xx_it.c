#include "main.h"
extern CAN_HandleTypeDef hcan1;
extern TIM_HandleTypeDef htim6;
void SysTick_Handler(void) { HAL_IncTick(); }
void CAN1_RX0_IRQHandler(void) { HAL_CAN_IRQHandler(&hcan1); }
void TIM6_DAC_IRQHandler(void) { HAL_TIM_IRQHandler(&htim6); }
