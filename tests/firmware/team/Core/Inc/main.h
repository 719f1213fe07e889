#ifndef __MAIN_H
#define __MAIN_H
#include "stm32f4xx_hal.h"
#define LED_R_Pin GPIO_PIN_11
#define LED_R_GPIO_Port GPIOE
#define KICK_Pin GPIO_PIN_4
#define KICK_GPIO_Port GPIOC
void Error_Handler(void);
#endif
