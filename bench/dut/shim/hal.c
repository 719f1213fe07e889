/* The HAL's calls beside UARTs (hal_uart.c) and CAN (hal_can.c): processor, timers, and what a board has beside them. */
#include "core.h"
#include "hal.h"

#include "usb_device.h"
#include "usbd_cdc_if.h"

#include <string.h>

__IO uint32_t uwTick;
uint32_t SystemCoreClock = 168000000;
GPIO_TypeDef wb_gpio[8];
TIM_TypeDef wb_tim[25];
CoreDebug_Type wb_core_debug;

static uint32_t primask;

/* The firmware's own, where it has them. */
void OPTIONAL SysTick_Handler(void);
void OPTIONAL HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *timer);
void OPTIONAL HAL_TIM_Base_MspInit(TIM_HandleTypeDef *timer);
void OPTIONAL HAL_MspInit(void);

/* --- the processor ------------------------------------------------------------------------------------------------ */

HAL_StatusTypeDef HAL_Init(void) {
    if (HAL_MspInit)
        HAL_MspInit();
    return HAL_OK;
}

HAL_StatusTypeDef HAL_DeInit(void) {
    return HAL_OK;
}

void OPTIONAL HAL_IncTick(void) {
    uwTick++;
}

uint32_t OPTIONAL HAL_GetTick(void) {
    wb_poll();
    return uwTick;
}

void OPTIONAL HAL_Delay(uint32_t ms) {
    /* At least as long as asked for: the tick that has begun does not count. */
    for (uint32_t start = uwTick; uwTick - start <= ms;)
        wb_end_tick();
}

void HAL_SuspendTick(void) {}
void HAL_ResumeTick(void) {}

void NVIC_SystemReset(void) {
    wb_fault(WB_FAULT_ASSERT, "the firmware resets itself (NVIC_SystemReset)");
}

uint32_t __get_PRIMASK(void) {
    return primask;
}

void __set_PRIMASK(uint32_t mask) {
    primask = mask & 1;
    primask ? wb_irq_off() : wb_irq_on();
}

void __disable_irq(void) {
    __set_PRIMASK(1);
}

void __enable_irq(void) {
    __set_PRIMASK(0);
}

void __WFI(void) {
    wb_wait();
}

/* --- what the board has beside them ------------------------------------------------------------------------------- */

DWT_Type *wb_dwt(void) {
    static DWT_Type dwt;
    static uint32_t given, given_at, begun_at;
    if (dwt.CYCCNT != given) /* the firmware has set it */
        begun_at = given_at - dwt.CYCCNT;
    wb_poll();
    given_at = wb_share_of_time(SystemCoreClock / 1000);
    dwt.CYCCNT = given = given_at - begun_at;
    return &dwt;
}

static UART_HandleTypeDef *receives_by(const DMA_HandleTypeDef *dma) {
    for (int wire = 0; wire < WB_UARTS; wire++)
        if (wb_hal_uarts[wire] && wb_hal_uarts[wire]->hdmarx == dma)
            return wb_hal_uarts[wire];
    return NULL;
}

uint32_t wb_dma_left(const DMA_HandleTypeDef *dma) {
    const UART_HandleTypeDef *uart = receives_by(dma);
    wb_poll();
    return uart ? uart->RxXferCount : 0;
}

void wb_dma_restart(const DMA_HandleTypeDef *dma, uint32_t count) {
    UART_HandleTypeDef *uart = receives_by(dma);
    if (uart) /* from the beginning of its memory, as a DMA that has been disabled does */
        uart->RxXferSize = uart->RxXferCount = (uint16_t)count;
}

uint32_t OPTIONAL HAL_ADC_GetValue(ADC_HandleTypeDef *adc) {
    UNUSED(adc);
    wb_note_once("HAL_ADC_GetValue gives 0 here; define it in wheelbench_port.c where your firmware wants a battery");
    return 0;
}

void OPTIONAL MX_USB_DEVICE_Init(void) {}

uint8_t OPTIONAL CDC_Transmit_FS(uint8_t *data, uint16_t size) {
    wb_print(data, size);
    return USBD_OK;
}

uint8_t OPTIONAL CDC_Transmit_HS(uint8_t *data, uint16_t size) {
    return CDC_Transmit_FS(data, size);
}

static HAL_StatusTypeDef nobody_answers(uint8_t *to, uint16_t size) {
    wb_note_once("SPI and I2C read 0 here, nobody is there; define the HAL's call in wheelbench_port.c to answer");
    memset(to, 0, size);
    return HAL_OK;
}

HAL_StatusTypeDef OPTIONAL HAL_SPI_Receive(SPI_HandleTypeDef *spi, uint8_t *to, uint16_t size, uint32_t timeout) {
    UNUSED(spi);
    UNUSED(timeout);
    return nobody_answers(to, size);
}

HAL_StatusTypeDef OPTIONAL HAL_SPI_TransmitReceive(
    SPI_HandleTypeDef *spi, const uint8_t *from, uint8_t *to, uint16_t size, uint32_t timeout) {
    UNUSED(spi);
    UNUSED(from);
    UNUSED(timeout);
    return nobody_answers(to, size);
}

HAL_StatusTypeDef OPTIONAL HAL_I2C_Master_Receive(
    I2C_HandleTypeDef *i2c, uint16_t address, uint8_t *to, uint16_t size, uint32_t timeout) {
    UNUSED(i2c);
    UNUSED(address);
    UNUSED(timeout);
    return nobody_answers(to, size);
}

HAL_StatusTypeDef OPTIONAL HAL_I2C_Mem_Read(
    I2C_HandleTypeDef *i2c, uint16_t address, uint16_t at, uint16_t at_size, uint8_t *to, uint16_t size, uint32_t timeout) {
    UNUSED(i2c);
    UNUSED(address);
    UNUSED(at + at_size);
    UNUSED(timeout);
    return nobody_answers(to, size);
}

/* --- timers ------------------------------------------------------------------------------------------------------- */

HAL_StatusTypeDef OPTIONAL HAL_TIM_Base_Init(TIM_HandleTypeDef *timer) {
    if (HAL_TIM_Base_MspInit)
        HAL_TIM_Base_MspInit(timer);
    return HAL_OK;
}

HAL_StatusTypeDef HAL_TIM_Base_Start_IT(TIM_HandleTypeDef *timer) {
    timer->wb_running = 1;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_TIM_Base_Stop_IT(TIM_HandleTypeDef *timer) {
    timer->wb_running = 0;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_TIM_RegisterCallback(
    TIM_HandleTypeDef *timer, HAL_TIM_CallbackIDTypeDef which, void (*call)(TIM_HandleTypeDef *)) {
    if (which == HAL_TIM_PERIOD_ELAPSED_CB_ID)
        timer->PeriodElapsedCallback = call;
    return HAL_OK;
}

void OPTIONAL HAL_TIM_IRQHandler(TIM_HandleTypeDef *timer) {
    UNUSED(timer);
}

static void timer_interrupts(void) {
    for (const struct wb_hal_timer *each = wb_hal_timers; each->timer; each++)
        if (each->timer->wb_running && wb_tick % each->period_ms == 0)
            WB_CALL(each->timer->PeriodElapsedCallback, HAL_TIM_PeriodElapsedCallback, each->timer);
}

static void tick_interrupt(void) {
    uint32_t before = uwTick;
    wb_rtos_was_asked = 0;
    if (SysTick_Handler)
        SysTick_Handler();
    /* Where it is the scheduler's alone, the HAL's ticks come from a timer, in a file that the bench leaves out. */
    if (!SysTick_Handler || (wb_rtos_was_asked && uwTick == before))
        HAL_IncTick();
}

void wb_hal_interrupts(const struct wb_input *input) {
    if (wb_tick) {
        tick_interrupt();
    }
    wb_can_interrupts(input);
    wb_uart_interrupts(WB_RC, input);
    wb_uart_interrupts(WB_SLAMWARE, input);
    wb_uart_sent_interrupts();
    timer_interrupts();
}
