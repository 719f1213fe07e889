#pragma once
#include "main.h"
void MX_GPIO_Init(void);
void MX_DMA_Init(void);
