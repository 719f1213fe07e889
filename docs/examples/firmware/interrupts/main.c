/* Interrupt handlers do the work, the main loop sleeps: an STM32F4 with its HAL, as a generator lays such a file out.
 * RC is SBUS, byte by byte. A timer calls the control step each millisecond.
 */
#include "main.h"

#include "driver.h"
#include "sbus.h"
#include "slamware.h"

CAN_HandleTypeDef hcan1;
UART_HandleTypeDef huart1; /* the receiver */
UART_HandleTypeDef huart6; /* the navigation core */
TIM_HandleTypeDef htim6;

static uint8_t rc_in, core_in, answer[64];
static volatile uint32_t last_frame_ms;
static volatile uint8_t has_frame;

static void clocks_init(void) {
    RCC_OscInitTypeDef oscillator = {0};
    RCC_ClkInitTypeDef clocks = {0};
    __HAL_RCC_PWR_CLK_ENABLE();
    __HAL_PWR_VOLTAGESCALING_CONFIG(PWR_REGULATOR_VOLTAGE_SCALE1);
    oscillator.OscillatorType = RCC_OSCILLATORTYPE_HSE;
    oscillator.HSEState = RCC_HSE_ON;
    oscillator.PLL.PLLState = RCC_PLL_ON;
    oscillator.PLL.PLLSource = RCC_PLLSOURCE_HSE;
    oscillator.PLL.PLLM = 6;
    oscillator.PLL.PLLN = 168;
    oscillator.PLL.PLLP = RCC_PLLP_DIV2;
    oscillator.PLL.PLLQ = 4;
    if (HAL_RCC_OscConfig(&oscillator) != HAL_OK)
        Error_Handler();
    clocks.ClockType = RCC_CLOCKTYPE_HCLK | RCC_CLOCKTYPE_SYSCLK | RCC_CLOCKTYPE_PCLK1 | RCC_CLOCKTYPE_PCLK2;
    clocks.SYSCLKSource = RCC_SYSCLKSOURCE_PLLCLK;
    clocks.AHBCLKDivider = RCC_SYSCLK_DIV1;
    clocks.APB1CLKDivider = RCC_HCLK_DIV4;
    clocks.APB2CLKDivider = RCC_HCLK_DIV2;
    if (HAL_RCC_ClockConfig(&clocks, FLASH_LATENCY_5) != HAL_OK)
        Error_Handler();
}

static void can_init(void) {
    CAN_FilterTypeDef all = {0};
    hcan1.Instance = CAN1;
    hcan1.Init.Prescaler = 3;
    hcan1.Init.Mode = CAN_MODE_NORMAL;
    hcan1.Init.SyncJumpWidth = CAN_SJW_1TQ;
    hcan1.Init.TimeSeg1 = CAN_BS1_10TQ;
    hcan1.Init.TimeSeg2 = CAN_BS2_3TQ;
    hcan1.Init.AutoBusOff = ENABLE;
    if (HAL_CAN_Init(&hcan1) != HAL_OK)
        Error_Handler();
    all.FilterMode = CAN_FILTERMODE_IDMASK;
    all.FilterScale = CAN_FILTERSCALE_32BIT;
    all.FilterFIFOAssignment = CAN_RX_FIFO0;
    all.FilterActivation = ENABLE;
    HAL_CAN_ConfigFilter(&hcan1, &all);
    HAL_CAN_Start(&hcan1);
    HAL_CAN_ActivateNotification(&hcan1, CAN_IT_RX_FIFO0_MSG_PENDING);
}

static void uart_init(UART_HandleTypeDef *uart, USART_TypeDef *instance, uint32_t baud, uint32_t parity) {
    uart->Instance = instance;
    uart->Init.BaudRate = baud;
    uart->Init.WordLength = parity == UART_PARITY_NONE ? UART_WORDLENGTH_8B : UART_WORDLENGTH_9B;
    uart->Init.StopBits = parity == UART_PARITY_NONE ? UART_STOPBITS_1 : UART_STOPBITS_2;
    uart->Init.Parity = parity;
    uart->Init.Mode = UART_MODE_TX_RX;
    if (HAL_UART_Init(uart) != HAL_OK)
        Error_Handler();
}

void HAL_UART_RxCpltCallback(UART_HandleTypeDef *uart) {
    uint32_t now_ms = HAL_GetTick();
    if (uart == &huart1) {
        sticks_t sticks;
        switch (sbus_byte(rc_in, now_ms, &sticks)) {
        case SBUS_FRAME:
            driver_frame(&sticks, now_ms);
            last_frame_ms = now_ms;
            has_frame = 1;
            break;
        case SBUS_FAILSAFE:
            driver_failsafe();
            break;
        case SBUS_NOTHING:
            break;
        }
        HAL_UART_Receive_IT(&huart1, &rc_in, 1);
    } else if (uart == &huart6) {
        int size = slamware_byte(core_in, now_ms, answer);
        if (size)
            HAL_UART_Transmit_IT(&huart6, answer, (uint16_t)size);
        HAL_UART_Receive_IT(&huart6, &core_in, 1);
    }
}

void HAL_CAN_RxFifo0MsgPendingCallback(CAN_HandleTypeDef *can) {
    CAN_RxHeaderTypeDef header;
    uint8_t data[8];
    if (HAL_CAN_GetRxMessage(can, CAN_RX_FIFO0, &header, data) == HAL_OK && header.IDE == CAN_ID_STD && header.DLC == 8)
        wheels_feedback((uint16_t)header.StdId, data, HAL_GetTick());
}

void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *timer) {
    CAN_TxHeaderTypeDef header = {.StdId = 0x200, .IDE = CAN_ID_STD, .RTR = CAN_RTR_DATA, .DLC = 8};
    uint32_t now_ms = HAL_GetTick(), mailbox;
    uint8_t data[8];
    if (timer->Instance != TIM6)
        return;
    wheels_step(has_frame ? driver_step(now_ms - last_frame_ms, now_ms) : 0, now_ms, data);
    if (HAL_CAN_GetTxMailboxesFreeLevel(&hcan1) > 0)
        HAL_CAN_AddTxMessage(&hcan1, &header, data, &mailbox);
}

int main(void) {
    HAL_Init();
    clocks_init();
    can_init();
    uart_init(&huart1, USART1, 100000, UART_PARITY_EVEN);
    uart_init(&huart6, USART6, 115200, UART_PARITY_NONE);
    htim6.Instance = TIM6;
    htim6.Init.Prescaler = 83;
    htim6.Init.Period = 999;
    if (HAL_TIM_Base_Init(&htim6) != HAL_OK)
        Error_Handler();
    HAL_UART_Receive_IT(&huart1, &rc_in, 1);
    HAL_UART_Receive_IT(&huart6, &core_in, 1);
    HAL_TIM_Base_Start_IT(&htim6);
    while (1)
        __WFI();
}

void Error_Handler(void) {
    __disable_irq();
    while (1) {
    }
}
