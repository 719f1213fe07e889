#include "can.h"
#include "robot.h"
volatile motor_t motors[3];
void motors_start(void)
{
  CAN_FilterTypeDef f = {0};
  f.FilterBank = 0;
  f.FilterMode = CAN_FILTERMODE_IDMASK;
  f.FilterScale = CAN_FILTERSCALE_32BIT;
  f.FilterFIFOAssignment = CAN_RX_FIFO0;
  f.FilterActivation = ENABLE;
  f.SlaveStartFilterBank = 14;
  HAL_CAN_ConfigFilter(&hcan1, &f);
  HAL_CAN_Start(&hcan1);
  HAL_CAN_ActivateNotification(&hcan1, CAN_IT_RX_FIFO0_MSG_PENDING);
}
void HAL_CAN_RxFifo0MsgPendingCallback(CAN_HandleTypeDef *hcan)
{
  CAN_RxHeaderTypeDef h;
  uint8_t d[8];
  if (HAL_CAN_GetRxMessage(hcan, CAN_RX_FIFO0, &h, d) != HAL_OK) return;
  if (h.StdId < 0x201 || h.StdId > 0x203) return;
  volatile motor_t *m = &motors[h.StdId - 0x201];
  m->angle = d[0] << 8 | d[1];
  m->rpm = (int16_t)(d[2] << 8 | d[3]);
  m->current = (int16_t)(d[4] << 8 | d[5]);
  m->last_ms = HAL_GetTick();
}
void motors_send(const int16_t ma[3])
{
  CAN_TxHeaderTypeDef h = {.StdId = 0x200, .IDE = CAN_ID_STD, .RTR = CAN_RTR_DATA, .DLC = 8};
  uint8_t d[8] = {0};
  uint32_t mailbox;
  for (int i = 0; i < 3; i++) { d[2*i] = ma[i] >> 8; d[2*i+1] = ma[i]; }
  HAL_CAN_AddTxMessage(&hcan1, &h, d, &mailbox);
}
