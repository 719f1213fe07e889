/* What a team has on its first day with the bench: a generator's layout, DBUS by DMA and IDLE, a level switch that arms,
 * a console on USART3, a cycle counter, a battery on an ADC. Not a byte of it knows of the bench.
 */
#include "main.h"
#include "can.h"
#include "usart.h"
#include "tim.h"
#include "gpio.h"
#include "robot.h"
#include <stdio.h>

uint8_t dbus_buf[36];
IWDG_HandleTypeDef hiwdg;
ADC_HandleTypeDef hadc1;
volatile uint32_t loop_us;

void SystemClock_Config(void);

int __io_putchar(int ch)
{
  HAL_UART_Transmit(&huart3, (uint8_t *)&ch, 1, HAL_MAX_DELAY);
  return ch;
}

static void delay_us(uint32_t us)
{
  uint32_t start = DWT->CYCCNT;
  while (DWT->CYCCNT - start < us * 168) {}
}

void HAL_UARTEx_RxEventCallback(UART_HandleTypeDef *huart, uint16_t Size)
{
  if (huart->Instance == USART1) {
    dbus_feed(dbus_buf, Size);
    HAL_UARTEx_ReceiveToIdle_DMA(&huart1, dbus_buf, sizeof dbus_buf);
  }
}

void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *htim)
{
  if (htim->Instance == TIM6) {
    uint32_t t0 = DWT->CYCCNT;
    drive_step();
    loop_us = (DWT->CYCCNT - t0) / 168;
  }
}

int main(void)
{
  HAL_Init();
  SystemClock_Config();
  MX_GPIO_Init();
  MX_DMA_Init();
  MX_CAN1_Init();
  MX_USART1_UART_Init();
  MX_USART3_UART_Init();
  MX_TIM6_Init();
  CoreDebug->DEMCR |= CoreDebug_DEMCR_TRCENA_Msk;
  DWT->CTRL |= DWT_CTRL_CYCCNTENA_Msk;
  delay_us(20000); /* the ESCs come up */
  printf("SSL robot 2026 ready\r\n");
  motors_start();
  HAL_UARTEx_ReceiveToIdle_DMA(&huart1, dbus_buf, sizeof dbus_buf);
  __HAL_DMA_DISABLE_IT(huart1.hdmarx, DMA_IT_HT);
  HAL_TIM_Base_Start_IT(&htim6);
  uint32_t blink = 0;
  while (1)
  {
    if (HAL_GetTick() - blink > 500) {
      blink = HAL_GetTick();
      HAL_GPIO_TogglePin(LED_R_GPIO_Port, LED_R_Pin);
      printf("rc sw %d %d %d %d age %lu\r\n", rc.sw[0], rc.ch[1], rc.ch[2], rc.ch[3], blink - rc.last_ms);
    }
    HAL_IWDG_Refresh(&hiwdg);
    HAL_ADC_Start(&hadc1);
    if (HAL_ADC_PollForConversion(&hadc1, 1) == HAL_OK) { uint32_t batt = HAL_ADC_GetValue(&hadc1); (void)batt; }
  }
}

void SystemClock_Config(void)
{
  RCC_OscInitTypeDef RCC_OscInitStruct = {0};
  RCC_ClkInitTypeDef RCC_ClkInitStruct = {0};
  __HAL_RCC_PWR_CLK_ENABLE();
  __HAL_PWR_VOLTAGESCALING_CONFIG(PWR_REGULATOR_VOLTAGE_SCALE1);
  RCC_OscInitStruct.OscillatorType = RCC_OSCILLATORTYPE_HSE;
  RCC_OscInitStruct.HSEState = RCC_HSE_ON;
  RCC_OscInitStruct.PLL.PLLState = RCC_PLL_ON;
  RCC_OscInitStruct.PLL.PLLSource = RCC_PLLSOURCE_HSE;
  RCC_OscInitStruct.PLL.PLLM = 6;
  RCC_OscInitStruct.PLL.PLLN = 168;
  RCC_OscInitStruct.PLL.PLLP = RCC_PLLP_DIV2;
  RCC_OscInitStruct.PLL.PLLQ = 4;
  if (HAL_RCC_OscConfig(&RCC_OscInitStruct) != HAL_OK) Error_Handler();
  RCC_ClkInitStruct.ClockType = RCC_CLOCKTYPE_HCLK|RCC_CLOCKTYPE_SYSCLK|RCC_CLOCKTYPE_PCLK1|RCC_CLOCKTYPE_PCLK2;
  RCC_ClkInitStruct.SYSCLKSource = RCC_SYSCLKSOURCE_PLLCLK;
  if (HAL_RCC_ClockConfig(&RCC_ClkInitStruct, FLASH_LATENCY_5) != HAL_OK) Error_Handler();
}

void Error_Handler(void)
{
  __disable_irq();
  while (1) {}
}
