#pragma once
#include "main.h"
extern CAN_HandleTypeDef hcan1;
void MX_CAN1_Init(void);
