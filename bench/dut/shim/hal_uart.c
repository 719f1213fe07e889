/* The HAL's calls on the serial wires. What a real UART forgives is forgiven here, and no more: a reception that nobody
 * arms again hears nothing.
 */
#include "core.h"
#include "hal.h"

#include <string.h>

enum { NO_UART = -1, MOST_UARTS = 32 };

USART_TypeDef wb_usart[12];

static int heard[WB_UARTS]; /* bytes since the line was idle */
static UART_HandleTypeDef *sending[MOST_UARTS]; /* by interrupt or DMA, in this millisecond; a console too */
static int sending_count;

/* The firmware's own, where it has them. */
void OPTIONAL HAL_UART_RxCpltCallback(UART_HandleTypeDef *uart);
void OPTIONAL HAL_UART_TxCpltCallback(UART_HandleTypeDef *uart);
void OPTIONAL HAL_UART_RxHalfCpltCallback(UART_HandleTypeDef *uart);
void OPTIONAL HAL_UARTEx_RxEventCallback(UART_HandleTypeDef *uart, uint16_t size);
void OPTIONAL HAL_UART_MspInit(UART_HandleTypeDef *uart);

/* USART3's, which is UART3's elsewhere: whichever the firmware has. */
#define HANDLERS(number) {USART##number##_IRQHandler, UART##number##_IRQHandler}
#define DECLARED(number) void OPTIONAL USART##number##_IRQHandler(void); void OPTIONAL UART##number##_IRQHandler(void);
DECLARED(1) DECLARED(2) DECLARED(3) DECLARED(4) DECLARED(5) DECLARED(6) DECLARED(7) DECLARED(8) DECLARED(9) DECLARED(10)
static void (*const handlers[][2])(void) = {
    {NULL, NULL}, HANDLERS(1), HANDLERS(2), HANDLERS(3), HANDLERS(4), HANDLERS(5), HANDLERS(6), HANDLERS(7), HANDLERS(8),
    HANDLERS(9), HANDLERS(10),
};

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
    if (uart->wb_sent)
        return HAL_BUSY;
    send(uart, data, size);
    return HAL_OK;
}

HAL_StatusTypeDef HAL_UART_Transmit_IT(UART_HandleTypeDef *uart, const uint8_t *data, uint16_t size) {
    if (!data || !size)
        return HAL_ERROR;
    if (uart->wb_sent || sending_count == MOST_UARTS)
        return HAL_BUSY;
    send(uart, data, size);
    sending[sending_count++] = uart;
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

static HAL_StatusTypeDef arm(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size, uint8_t by_dma, uint8_t to_idle) {
    if (!data || !size)
        return HAL_ERROR;
    if (uart->RxState == HAL_UART_STATE_BUSY_RX)
        return HAL_BUSY;
    int wire = wire_of(uart);
    if (wire != NO_UART)
        wb_forget_bytes(wire); /* what came while nobody listened is lost */
    uart->pRxBuffPtr = data;
    uart->RxXferSize = uart->RxXferCount = size;
    uart->wb_by_dma = by_dma;
    if (by_dma && uart->hdmarx)
        uart->hdmarx->wb_no_half = 0; /* each start lets the half be told again */
    uart->wb_to_idle = to_idle;
    uart->ReceptionType = to_idle ? HAL_UART_RECEPTION_TOIDLE : HAL_UART_RECEPTION_STANDARD;
    uart->RxState = HAL_UART_STATE_BUSY_RX;
    return HAL_OK;
}

static int is_circular(const UART_HandleTypeDef *uart) {
    return uart->wb_by_dma && uart->hdmarx && uart->hdmarx->Init.Mode == DMA_CIRCULAR;
}

HAL_StatusTypeDef HAL_UART_Receive_IT(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size) {
    return arm(uart, data, size, 0, 0);
}

HAL_StatusTypeDef HAL_UART_Receive_DMA(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size) {
    return arm(uart, data, size, 1, 0);
}

HAL_StatusTypeDef HAL_UARTEx_ReceiveToIdle_IT(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size) {
    return arm(uart, data, size, 0, 1);
}

HAL_StatusTypeDef HAL_UARTEx_ReceiveToIdle_DMA(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size) {
    return arm(uart, data, size, 1, 1);
}

HAL_StatusTypeDef HAL_UART_AbortReceive(UART_HandleTypeDef *uart) {
    uart->RxState = HAL_UART_STATE_READY;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_UART_AbortReceive_IT(UART_HandleTypeDef *uart) {
    return HAL_UART_AbortReceive(uart);
}

HAL_StatusTypeDef HAL_UART_Abort(UART_HandleTypeDef *uart) {
    return HAL_UART_AbortReceive(uart);
}

HAL_StatusTypeDef HAL_UART_DMAStop(UART_HandleTypeDef *uart) {
    return HAL_UART_AbortReceive(uart);
}

HAL_UART_StateTypeDef HAL_UART_GetState(const UART_HandleTypeDef *uart) {
    return uart->gState | uart->RxState;
}

HAL_UART_RxEventTypeTypeDef HAL_UARTEx_GetRxEventType(const UART_HandleTypeDef *uart) {
    return uart->RxEventType;
}

HAL_StatusTypeDef HAL_UART_RegisterCallback(
    UART_HandleTypeDef *uart, HAL_UART_CallbackIDTypeDef which, void (*call)(UART_HandleTypeDef *)) {
    if (which == HAL_UART_RX_COMPLETE_CB_ID)
        uart->RxCpltCallback = call;
    else if (which == HAL_UART_RX_HALFCOMPLETE_CB_ID)
        uart->RxHalfCpltCallback = call;
    else if (which == HAL_UART_TX_COMPLETE_CB_ID)
        uart->TxCpltCallback = call;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_UART_RegisterRxEventCallback(
    UART_HandleTypeDef *uart, void (*call)(UART_HandleTypeDef *, uint16_t)) {
    uart->RxEventCallback = call;
    return HAL_OK;
}

void OPTIONAL HAL_UART_IRQHandler(UART_HandleTypeDef *uart) {
    UNUSED(uart);
}

static void tell(UART_HandleTypeDef *uart, HAL_UART_RxEventTypeTypeDef what) {
    uint16_t size = (uint16_t)(uart->RxXferSize - uart->RxXferCount);
    uart->RxEventType = what;
    if (what != HAL_UART_RXEVENT_HT) {
        if (!is_circular(uart))
            uart->RxState = HAL_UART_STATE_READY;
        else if (what == HAL_UART_RXEVENT_TC)
            uart->RxXferCount = uart->RxXferSize;
    }
    if (uart->wb_to_idle)
        WB_CALL(uart->RxEventCallback, HAL_UARTEx_RxEventCallback, uart, size);
    else if (what == HAL_UART_RXEVENT_HT)
        WB_CALL(uart->RxHalfCpltCallback, HAL_UART_RxHalfCpltCallback, uart);
    else
        WB_CALL(uart->RxCpltCallback, HAL_UART_RxCpltCallback, uart);
}

/* A DMA tells its half too, until __HAL_DMA_DISABLE_IT(..., DMA_IT_HT); one that is linked to no UART cannot be asked. */
static int tells_half(const UART_HandleTypeDef *uart) {
    return uart->wb_by_dma && uart->hdmarx && !uart->hdmarx->wb_no_half;
}

static void uart_byte(int wire, UART_HandleTypeDef *uart, uint8_t byte) {
    if (!uart || uart->RxState != HAL_UART_STATE_BUSY_RX) {
        wb_keep_byte(wire, byte);
        return;
    }
    uart->pRxBuffPtr[uart->RxXferSize - uart->RxXferCount] = byte;
    if (--uart->RxXferCount == 0)
        tell(uart, HAL_UART_RXEVENT_TC);
    else if (uart->RxXferCount == (uart->RxXferSize + 1) / 2 && tells_half(uart))
        tell(uart, HAL_UART_RXEVENT_HT);
}

FlagStatus wb_uart_flag(const UART_HandleTypeDef *uart, uint32_t which) {
    wb_poll();
    if (which == UART_FLAG_IDLE)
        return uart->wb_is_idle ? SET : RESET;
    return which == UART_FLAG_TC || which == UART_FLAG_TXE ? (uart->wb_sent ? RESET : SET) : RESET;
}

/* The line is idle, and the firmware has asked to be told in its own handler. */
static void idle_interrupt(UART_HandleTypeDef *uart) {
    size_t number = (size_t)(uart->Instance - wb_usart);
    int is_one = number < sizeof handlers / sizeof *handlers;
    uart->wb_is_idle = 1;
    if (is_one && handlers[number][0])
        handlers[number][0]();
    else if (is_one && handlers[number][1])
        handlers[number][1]();
    else
        wb_note_once("UART_IT_IDLE is asked for, and no source has the UART's interrupt handler (USART3_IRQHandler or the "
                     "like): put the file that has it, stm32..._it.c perhaps, among sources");
}

void wb_uart_interrupts(int wire, const struct wb_input *input) {
    UART_HandleTypeDef *uart = wb_hal_uarts[wire];
    for (int i = 0; i < input->counts[wire]; i++)
        uart_byte(wire, uart, input->bytes[wire][i]);
    if (input->counts[wire]) {
        heard[wire] += input->counts[wire];
    } else if (heard[wire]) { /* the line is idle: a millisecond without a byte */
        heard[wire] = 0;
        if (uart && uart->RxState == HAL_UART_STATE_BUSY_RX && uart->wb_to_idle && uart->RxXferCount != uart->RxXferSize)
            tell(uart, HAL_UART_RXEVENT_IDLE);
        else if (uart && uart->wb_asks_idle)
            idle_interrupt(uart);
    }
}

void wb_uart_sent_interrupts(void) {
    UART_HandleTypeDef *sent[MOST_UARTS];
    int count = sending_count;
    memcpy(sent, sending, sizeof sent);
    sending_count = 0; /* a callback may send again */
    for (int i = 0; i < count; i++) {
        sent[i]->wb_sent = 0;
        sent[i]->gState = HAL_UART_STATE_READY;
        WB_CALL(sent[i]->TxCpltCallback, HAL_UART_TxCpltCallback, sent[i]);
    }
}
