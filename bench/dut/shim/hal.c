/* The HAL's calls on the bench's wires. What a real UART or controller forgives is forgiven here, and no more: a
 * reception that nobody arms again hears nothing, a CAN controller that nobody starts is silent.
 */
#include "core.h"
#include "hal.h"

#include <string.h>

enum { MAILBOXES = 3, NO_UART = -1 };

__IO uint32_t uwTick;
uint32_t SystemCoreClock = 168000000;
GPIO_TypeDef wb_gpio[8];
USART_TypeDef wb_usart[9];
CAN_TypeDef wb_can_instance[4];
FDCAN_GlobalTypeDef wb_fdcan_instance[4];
TIM_TypeDef wb_tim[18];
CoreDebug_Type wb_core_debug;

static uint32_t primask;
static int heard[WB_UARTS]; /* bytes since the line was idle */

/* The firmware's own, where it has them. */
#define OPTIONAL __attribute__((weak))
void OPTIONAL SysTick_Handler(void);
void OPTIONAL HAL_UART_RxCpltCallback(UART_HandleTypeDef *uart);
void OPTIONAL HAL_UART_TxCpltCallback(UART_HandleTypeDef *uart);
void OPTIONAL HAL_UART_RxHalfCpltCallback(UART_HandleTypeDef *uart);
void OPTIONAL HAL_UARTEx_RxEventCallback(UART_HandleTypeDef *uart, uint16_t size);
void OPTIONAL HAL_CAN_RxFifo0MsgPendingCallback(CAN_HandleTypeDef *can);
void OPTIONAL HAL_CAN_RxFifo1MsgPendingCallback(CAN_HandleTypeDef *can);
void OPTIONAL HAL_FDCAN_RxFifo0Callback(FDCAN_HandleTypeDef *can, uint32_t which);
void OPTIONAL HAL_FDCAN_RxFifo1Callback(FDCAN_HandleTypeDef *can, uint32_t which);
void OPTIONAL HAL_FDCAN_MspInit(FDCAN_HandleTypeDef *can);
void OPTIONAL HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *timer);
void OPTIONAL HAL_UART_MspInit(UART_HandleTypeDef *uart);
void OPTIONAL HAL_CAN_MspInit(CAN_HandleTypeDef *can);
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

/* --- UARTs -------------------------------------------------------------------------------------------------------- */

static int wire_of(const UART_HandleTypeDef *uart) {
    for (int wire = 0; wire < WB_UARTS; wire++)
        if (wb_hal_uarts[wire] == uart)
            return wire;
    return NO_UART;
}

HAL_StatusTypeDef OPTIONAL HAL_UART_Init(UART_HandleTypeDef *uart) {
    if (!uart)
        return HAL_ERROR;
    if (HAL_UART_MspInit)
        HAL_UART_MspInit(uart);
    uart->gState = uart->RxState = HAL_UART_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_UART_DeInit(UART_HandleTypeDef *uart) {
    uart->gState = uart->RxState = HAL_UART_STATE_RESET;
    return HAL_OK;
}

static void send(UART_HandleTypeDef *uart, const uint8_t *data, uint16_t size) {
    int wire = wire_of(uart);
    if (wire != NO_UART)
        wb_uart_write(wire, data, size);
    else
        wb_print(data, size); /* a console, most likely */
}

HAL_StatusTypeDef HAL_UART_Transmit(UART_HandleTypeDef *uart, const uint8_t *data, uint16_t size, uint32_t timeout) {
    UNUSED(timeout);
    if (!data || !size)
        return HAL_ERROR;
    send(uart, data, size);
    return HAL_OK;
}

HAL_StatusTypeDef HAL_UART_Transmit_IT(UART_HandleTypeDef *uart, const uint8_t *data, uint16_t size) {
    if (!data || !size)
        return HAL_ERROR;
    if (uart->wb_sent)
        return HAL_BUSY;
    send(uart, data, size);
    uart->wb_sent = 1;
    uart->gState = HAL_UART_STATE_BUSY_TX;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_UART_Transmit_DMA(UART_HandleTypeDef *uart, const uint8_t *data, uint16_t size) {
    return HAL_UART_Transmit_IT(uart, data, size);
}

HAL_StatusTypeDef HAL_UART_Receive(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size, uint32_t timeout) {
    int wire = wire_of(uart);
    uint32_t start = wb_tick;
    if (!data || !size)
        return HAL_ERROR;
    if (uart->RxState == HAL_UART_STATE_BUSY_RX)
        return HAL_BUSY;
    for (int count = 0;;) {
        count += wire == NO_UART ? 0 : wb_uart_read(wire, data + count, size - count);
        if (count == size)
            return HAL_OK;
        if (wb_tick - start >= timeout) {
            wb_poll();
            return HAL_TIMEOUT;
        }
        wb_end_tick();
    }
}

static HAL_StatusTypeDef arm(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size, uint8_t circular, uint8_t to_idle) {
    if (!data || !size)
        return HAL_ERROR;
    if (uart->RxState == HAL_UART_STATE_BUSY_RX)
        return HAL_BUSY;
    int wire = wire_of(uart);
    if (wire != NO_UART)
        wb_forget_bytes(wire); /* what came while nobody listened is lost */
    uart->pRxBuffPtr = data;
    uart->RxXferSize = uart->RxXferCount = size;
    uart->wb_circular = circular;
    uart->wb_to_idle = to_idle;
    uart->ReceptionType = to_idle ? HAL_UART_RECEPTION_TOIDLE : HAL_UART_RECEPTION_STANDARD;
    uart->RxState = HAL_UART_STATE_BUSY_RX;
    return HAL_OK;
}

static int is_circular(const UART_HandleTypeDef *uart) {
    return uart->hdmarx && uart->hdmarx->Init.Mode == DMA_CIRCULAR;
}

HAL_StatusTypeDef HAL_UART_Receive_IT(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size) {
    return arm(uart, data, size, 0, 0);
}

HAL_StatusTypeDef HAL_UART_Receive_DMA(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size) {
    return arm(uart, data, size, (uint8_t)is_circular(uart), 0);
}

HAL_StatusTypeDef HAL_UARTEx_ReceiveToIdle_IT(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size) {
    return arm(uart, data, size, 0, 1);
}

HAL_StatusTypeDef HAL_UARTEx_ReceiveToIdle_DMA(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size) {
    return arm(uart, data, size, (uint8_t)is_circular(uart), 1);
}

HAL_StatusTypeDef HAL_UART_AbortReceive(UART_HandleTypeDef *uart) {
    uart->RxState = HAL_UART_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_UART_AbortReceive_IT(UART_HandleTypeDef *uart) {
    return HAL_UART_AbortReceive(uart);
}

HAL_StatusTypeDef HAL_UART_DMAStop(UART_HandleTypeDef *uart) {
    return HAL_UART_AbortReceive(uart);
}

HAL_UART_StateTypeDef HAL_UART_GetState(const UART_HandleTypeDef *uart) {
    return uart->gState | uart->RxState;
}

void OPTIONAL HAL_UART_IRQHandler(UART_HandleTypeDef *uart) {
    UNUSED(uart);
}

static void reception_event(UART_HandleTypeDef *uart, int is_full) {
    uint16_t size = (uint16_t)(uart->RxXferSize - uart->RxXferCount);
    if (uart->wb_circular) {
        if (is_full)
            uart->RxXferCount = uart->RxXferSize;
    } else {
        uart->RxState = HAL_UART_STATE_READY;
    }
    if (uart->wb_to_idle) {
        if (HAL_UARTEx_RxEventCallback)
            HAL_UARTEx_RxEventCallback(uart, size);
    } else if (HAL_UART_RxCpltCallback) {
        HAL_UART_RxCpltCallback(uart);
    }
}

static void uart_byte(int wire, UART_HandleTypeDef *uart, uint8_t byte) {
    if (!uart || uart->RxState != HAL_UART_STATE_BUSY_RX) {
        wb_keep_byte(wire, byte);
        return;
    }
    uart->pRxBuffPtr[uart->RxXferSize - uart->RxXferCount] = byte;
    if (--uart->RxXferCount == 0)
        reception_event(uart, 1);
    else if (uart->wb_circular && uart->RxXferCount == uart->RxXferSize / 2 && !uart->wb_to_idle && HAL_UART_RxHalfCpltCallback)
        HAL_UART_RxHalfCpltCallback(uart);
}

static void uart_interrupts(int wire, const struct wb_input *input) {
    UART_HandleTypeDef *uart = wb_hal_uarts[wire];
    for (int i = 0; i < input->counts[wire]; i++)
        uart_byte(wire, uart, input->bytes[wire][i]);
    if (input->counts[wire]) {
        heard[wire] += input->counts[wire];
    } else if (heard[wire]) { /* the line is idle: a millisecond without a byte */
        heard[wire] = 0;
        if (uart && uart->RxState == HAL_UART_STATE_BUSY_RX && uart->wb_to_idle && uart->RxXferCount != uart->RxXferSize)
            reception_event(uart, 0);
    }
    if (uart && uart->wb_sent) {
        uart->wb_sent = 0;
        uart->gState = HAL_UART_STATE_READY;
        if (HAL_UART_TxCpltCallback)
            HAL_UART_TxCpltCallback(uart);
    }
}

/* --- CAN ---------------------------------------------------------------------------------------------------------- */

static int is_the_bus(const CAN_HandleTypeDef *can) {
    return can && can == wb_hal_can && can->State == HAL_CAN_STATE_LISTENING;
}

HAL_StatusTypeDef OPTIONAL HAL_CAN_Init(CAN_HandleTypeDef *can) {
    if (!can)
        return HAL_ERROR;
    if (HAL_CAN_MspInit)
        HAL_CAN_MspInit(can);
    can->State = HAL_CAN_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_ConfigFilter(CAN_HandleTypeDef *can, const CAN_FilterTypeDef *filter) {
    UNUSED(can); /* every frame passes */
    UNUSED(filter);
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_Start(CAN_HandleTypeDef *can) {
    can->State = HAL_CAN_STATE_LISTENING;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_Stop(CAN_HandleTypeDef *can) {
    can->State = HAL_CAN_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_ActivateNotification(CAN_HandleTypeDef *can, uint32_t which) {
    can->wb_notifications |= which;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_DeactivateNotification(CAN_HandleTypeDef *can, uint32_t which) {
    can->wb_notifications &= ~which;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_CAN_AddTxMessage(
    CAN_HandleTypeDef *can, const CAN_TxHeaderTypeDef *header, const uint8_t data[], uint32_t *mailbox) {
    if (!can || (can->State != HAL_CAN_STATE_LISTENING && can->State != HAL_CAN_STATE_READY))
        return HAL_ERROR;
    if (header->DLC > 8)
        return HAL_ERROR;
    if (mailbox)
        *mailbox = CAN_TX_MAILBOX0;
    if (!is_the_bus(can))
        return HAL_OK; /* another bus, with nobody on it; or not started: it waits in its mailbox for ever */
    if (header->IDE != CAN_ID_STD || header->RTR != CAN_RTR_DATA) {
        wb_note_once("an extended or remote CAN frame was sent; the motors' bus carries none, and it is left out");
        return HAL_OK;
    }
    return wb_can_write((uint16_t)header->StdId, data, (uint8_t)header->DLC) ? HAL_OK : HAL_ERROR;
}

HAL_StatusTypeDef HAL_CAN_GetRxMessage(CAN_HandleTypeDef *can, uint32_t fifo, CAN_RxHeaderTypeDef *header, uint8_t data[]) {
    uint16_t id = 0;
    uint8_t bytes[8], length = 0;
    if (!is_the_bus(can) || fifo != wb_hal_fifo || !wb_can_read(&id, bytes, &length)) {
        wb_poll();
        return HAL_ERROR;
    }
    memset(header, 0, sizeof *header);
    header->StdId = id;
    header->IDE = CAN_ID_STD;
    header->RTR = CAN_RTR_DATA;
    header->DLC = length;
    header->Timestamp = wb_tick & 0xFFFF;
    memcpy(data, bytes, length);
    return HAL_OK;
}

uint32_t HAL_CAN_GetTxMailboxesFreeLevel(const CAN_HandleTypeDef *can) {
    UNUSED(can);
    if (wb_can_room() == 0)
        wb_poll();
    return (uint32_t)(wb_can_room() < MAILBOXES ? wb_can_room() : MAILBOXES);
}

uint32_t HAL_CAN_GetRxFifoFillLevel(const CAN_HandleTypeDef *can, uint32_t fifo) {
    if (!is_the_bus(can) || fifo != wb_hal_fifo || wb_can_waiting() == 0)
        wb_poll();
    return is_the_bus(can) && fifo == wb_hal_fifo ? (uint32_t)wb_can_waiting() : 0;
}

uint32_t HAL_CAN_IsTxMessagePending(const CAN_HandleTypeDef *can, uint32_t mailboxes) {
    UNUSED(can);
    UNUSED(mailboxes);
    return 0;
}

uint32_t HAL_CAN_GetState(const CAN_HandleTypeDef *can) {
    return can->State;
}

uint32_t HAL_CAN_GetError(const CAN_HandleTypeDef *can) {
    return can->ErrorCode;
}

void OPTIONAL HAL_CAN_IRQHandler(CAN_HandleTypeDef *can) {
    UNUSED(can);
}

/* --- FDCAN, for classic frames ------------------------------------------------------------------------------------ */

static int is_the_fd_bus(const FDCAN_HandleTypeDef *can) {
    return can && can == wb_hal_fdcan && can->State == HAL_CAN_STATE_LISTENING;
}

HAL_StatusTypeDef OPTIONAL HAL_FDCAN_Init(FDCAN_HandleTypeDef *can) {
    if (!can)
        return HAL_ERROR;
    if (HAL_FDCAN_MspInit)
        HAL_FDCAN_MspInit(can);
    can->State = HAL_CAN_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_ConfigFilter(FDCAN_HandleTypeDef *can, const FDCAN_FilterTypeDef *filter) {
    UNUSED(can); /* every frame passes */
    UNUSED(filter);
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_ConfigGlobalFilter(
    FDCAN_HandleTypeDef *can, uint32_t standard, uint32_t extended, uint32_t remote_standard, uint32_t remote_extended) {
    UNUSED(can);
    UNUSED(standard + extended + remote_standard + remote_extended);
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_Start(FDCAN_HandleTypeDef *can) {
    can->State = HAL_CAN_STATE_LISTENING;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_Stop(FDCAN_HandleTypeDef *can) {
    can->State = HAL_CAN_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_FDCAN_ActivateNotification(FDCAN_HandleTypeDef *can, uint32_t which, uint32_t buffers) {
    UNUSED(buffers);
    can->wb_notifications |= which;
    return HAL_OK;
}

/* A length code: 0 to 8, or as older versions of the interface have it, shifted by 16. */
static uint32_t length_of(uint32_t code) {
    return code > 0xFFFF ? code >> 16 : code;
}

HAL_StatusTypeDef HAL_FDCAN_AddMessageToTxFifoQ(
    FDCAN_HandleTypeDef *can, const FDCAN_TxHeaderTypeDef *header, const uint8_t *data) {
    if (!can || can->State != HAL_CAN_STATE_LISTENING)
        return HAL_ERROR;
    if (!is_the_fd_bus(can))
        return HAL_OK; /* another bus, with nobody on it */
    if (header->IdType != FDCAN_STANDARD_ID || header->TxFrameType != FDCAN_DATA_FRAME || length_of(header->DataLength) > 8) {
        wb_note_once("an extended, remote or long CAN frame was sent; the motors' bus carries none, and it is left out");
        return HAL_OK;
    }
    return wb_can_write((uint16_t)header->Identifier, data, (uint8_t)length_of(header->DataLength)) ? HAL_OK : HAL_ERROR;
}

static uint32_t fd_fifo(void) {
    return wb_hal_fifo == CAN_RX_FIFO0 ? FDCAN_RX_FIFO0 : FDCAN_RX_FIFO1;
}

HAL_StatusTypeDef HAL_FDCAN_GetRxMessage(
    FDCAN_HandleTypeDef *can, uint32_t fifo, FDCAN_RxHeaderTypeDef *header, uint8_t *data) {
    uint16_t id = 0;
    uint8_t bytes[8], length = 0;
    if (!is_the_fd_bus(can) || fifo != fd_fifo() || !wb_can_read(&id, bytes, &length)) {
        wb_poll();
        return HAL_ERROR;
    }
    memset(header, 0, sizeof *header);
    header->Identifier = id;
    header->DataLength = length;
    header->RxTimestamp = wb_tick & 0xFFFF;
    memcpy(data, bytes, length);
    return HAL_OK;
}

uint32_t HAL_FDCAN_GetTxFifoFreeLevel(const FDCAN_HandleTypeDef *can) {
    UNUSED(can);
    if (wb_can_room() == 0)
        wb_poll();
    return (uint32_t)(wb_can_room() < MAILBOXES ? wb_can_room() : MAILBOXES);
}

uint32_t HAL_FDCAN_GetRxFifoFillLevel(const FDCAN_HandleTypeDef *can, uint32_t fifo) {
    if (!is_the_fd_bus(can) || fifo != fd_fifo() || wb_can_waiting() == 0)
        wb_poll();
    return is_the_fd_bus(can) && fifo == fd_fifo() ? (uint32_t)wb_can_waiting() : 0;
}

void OPTIONAL HAL_FDCAN_IRQHandler(FDCAN_HandleTypeDef *can) {
    UNUSED(can);
}

/* --- frames that arrive, on either -------------------------------------------------------------------------------- */

static void fdcan_interrupts(const struct wb_input *input) {
    FDCAN_HandleTypeDef *can = wb_hal_fdcan;
    int is_first = wb_hal_fifo == CAN_RX_FIFO0;
    uint32_t wanted = is_first ? FDCAN_IT_RX_FIFO0_NEW_MESSAGE : FDCAN_IT_RX_FIFO1_NEW_MESSAGE;
    for (int i = 0; i < input->frame_count && can->State == HAL_CAN_STATE_LISTENING; i++) {
        wb_keep_frame(&input->frames[i]);
        if (!(can->wb_notifications & wanted))
            continue;
        if (is_first && HAL_FDCAN_RxFifo0Callback)
            HAL_FDCAN_RxFifo0Callback(can, wanted);
        else if (!is_first && HAL_FDCAN_RxFifo1Callback)
            HAL_FDCAN_RxFifo1Callback(can, wanted);
    }
}

static void can_interrupts(const struct wb_input *input) {
    CAN_HandleTypeDef *can = wb_hal_can;
    if (wb_hal_fdcan) {
        fdcan_interrupts(input);
        return;
    }
    uint32_t wanted = wb_hal_fifo == CAN_RX_FIFO0 ? CAN_IT_RX_FIFO0_MSG_PENDING : CAN_IT_RX_FIFO1_MSG_PENDING;
    for (int i = 0; i < input->frame_count; i++) {
        if (can && can->State != HAL_CAN_STATE_LISTENING)
            continue; /* a controller that has not been started hears nothing */
        wb_keep_frame(&input->frames[i]);
        if (!can || !(can->wb_notifications & wanted))
            continue;
        if (wb_hal_fifo == CAN_RX_FIFO0 && HAL_CAN_RxFifo0MsgPendingCallback)
            HAL_CAN_RxFifo0MsgPendingCallback(can);
        else if (wb_hal_fifo == CAN_RX_FIFO1 && HAL_CAN_RxFifo1MsgPendingCallback)
            HAL_CAN_RxFifo1MsgPendingCallback(can);
    }
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

uint32_t wb_dma_left(const DMA_HandleTypeDef *dma) {
    wb_poll();
    for (int wire = 0; wire < WB_UARTS; wire++)
        if (wb_hal_uarts[wire] && wb_hal_uarts[wire]->hdmarx == dma)
            return wb_hal_uarts[wire]->RxXferCount;
    return 0;
}

uint32_t OPTIONAL HAL_ADC_GetValue(ADC_HandleTypeDef *adc) {
    UNUSED(adc);
    wb_note_once("HAL_ADC_GetValue gives 0 here; define it in wheelbench_port.c where your firmware wants a battery");
    return 0;
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

void OPTIONAL HAL_TIM_IRQHandler(TIM_HandleTypeDef *timer) {
    UNUSED(timer);
}

static void timer_interrupts(void) {
    for (const struct wb_hal_timer *each = wb_hal_timers; each->timer; each++)
        if (each->timer->wb_running && wb_tick % each->period_ms == 0 && HAL_TIM_PeriodElapsedCallback)
            HAL_TIM_PeriodElapsedCallback(each->timer);
}

void wb_hal_interrupts(const struct wb_input *input) {
    if (wb_tick) {
        if (SysTick_Handler)
            SysTick_Handler();
        else
            HAL_IncTick();
    }
    can_interrupts(input);
    uart_interrupts(WB_RC, input);
    uart_interrupts(WB_SLAMWARE, input);
    timer_interrupts();
}
