#pragma once
#include "main.h"
extern TIM_HandleTypeDef htim6;
void MX_TIM6_Init(void);
