/* As much of the STM32 HAL's interface as a wheel base's own files use: UARTs, CAN, timers, ticks, pins, clocks.
 *
 * UARTs and CAN are the bench's wires, where the project's TOML file names their handles. Timers call back every so
 * many milliseconds. Pins, clocks, NVIC and what wheelbench_board.h has compile, succeed and do nothing. Registers are
 * not here: a file that uses them belongs to the board, and wheelbench_port.c has the place for what it did.
 *
 * Written from the interface's public documentation; nothing is copied from it. MIT licence.
 */
#ifndef WHEELBENCH_HAL_H
#define WHEELBENCH_HAL_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HAL_MODULE_ENABLED
#define UNUSED(value) ((void)(value))
#ifndef __IO
#define __IO volatile
#endif
#ifndef __weak
#define __weak __attribute__((weak))
#endif
#ifndef __WEAK
#define __WEAK __attribute__((weak))
#endif
#ifndef __packed
#define __packed __attribute__((packed))
#endif
#ifndef __ALIGN_BEGIN
#define __ALIGN_BEGIN
#define __ALIGN_END __attribute__((aligned(4)))
#endif
#ifndef __STATIC_INLINE
#define __STATIC_INLINE static inline
#endif

/* What is set up and done by nobody: such a call says that all is well. */
#define WB_SUCCEEDS(name, ...) \
    static inline HAL_StatusTypeDef name(__VA_ARGS__) { \
        return HAL_OK; \
    }
#define WB_DOES_NOTHING(name, ...) \
    static inline void name(__VA_ARGS__) {}
#define WB_UNUSED __attribute__((unused))

typedef enum { HAL_OK = 0, HAL_ERROR = 1, HAL_BUSY = 2, HAL_TIMEOUT = 3 } HAL_StatusTypeDef;
typedef enum { HAL_UNLOCKED = 0, HAL_LOCKED = 1 } HAL_LockTypeDef;
typedef enum { RESET = 0, SET = 1 } FlagStatus, ITStatus;
typedef enum { DISABLE = 0, ENABLE = 1 } FunctionalState;
typedef enum { ERROR = 0, SUCCESS = 1 } ErrorStatus;
#define HAL_MAX_DELAY 0xFFFFFFFFU
#define __HAL_LOCK(handle) ((void)(handle))
#define __HAL_UNLOCK(handle) ((void)(handle))

/* --- the processor ------------------------------------------------------------------------------------------------ */

HAL_StatusTypeDef HAL_Init(void);
HAL_StatusTypeDef HAL_DeInit(void);
void HAL_IncTick(void);
uint32_t HAL_GetTick(void);
void HAL_Delay(uint32_t ms);
void HAL_SuspendTick(void);
void HAL_ResumeTick(void);
void NVIC_SystemReset(void);
extern __IO uint32_t uwTick;
extern uint32_t SystemCoreClock;

void __disable_irq(void);
void __enable_irq(void);
void __WFI(void);
uint32_t __get_PRIMASK(void);
void __set_PRIMASK(uint32_t mask);
#define __NOP() ((void)0)
#define __WFE() __WFI()
#define __DSB() ((void)0)
#define __ISB() ((void)0)
#define __DMB() ((void)0)

typedef int IRQn_Type;
#define NVIC_PRIORITYGROUP_4 3U
#define HAL_NVIC_SetPriorityGrouping(group) ((void)(group))
#define HAL_NVIC_SetPriority(irq, preempt, sub) ((void)(irq))
#define HAL_NVIC_EnableIRQ(irq) ((void)(irq))
#define HAL_NVIC_DisableIRQ(irq) ((void)(irq))

/* --- clocks: settings are taken and kept by nobody ---------------------------------------------------------------- */

/* Names that are set-up alone (RCC_..., GPIO_AF..., ..._IRQn, clock gates) come from bench/dut/setup_names.py. */
#ifndef WB_CLOCK_SELECTIONS
#define WB_CLOCK_SELECTIONS
#define WB_ADC_INIT
#define WB_ADC_CHANNEL
#define WB_CRC_INIT
#define WB_DAC_INIT
#define WB_I2C_INIT
#define WB_RNG_INIT
#define WB_RTC_INIT
#define WB_SPI_INIT
#define WB_TIM_INIT
#endif

typedef struct {
    uint32_t PLLState, PLLSource, PLLM, PLLN, PLLP, PLLQ, PLLR, PLLMUL, PREDIV, PLLRGE, PLLVCOSEL, PLLFRACN;
} RCC_PLLInitTypeDef;
typedef struct {
    uint32_t OscillatorType, HSEState, LSEState, HSIState, HSIDiv, HSICalibrationValue, LSIState, HSI14State,
        HSI14CalibrationValue, HSI48State, CSIState, CSICalibrationValue, MSIState, MSICalibrationValue, MSIClockRange,
        HSEPredivValue, Prediv1Source;
    RCC_PLLInitTypeDef PLL;
} RCC_OscInitTypeDef;
typedef struct {
    uint32_t ClockType, SYSCLKSource, SYSCLKDivider, AHBCLKDivider, APB1CLKDivider, APB2CLKDivider, APB3CLKDivider,
        APB4CLKDivider;
} RCC_ClkInitTypeDef;
typedef struct {
    uint32_t PLL2M, PLL2N, PLL2P, PLL2Q, PLL2R, PLL2RGE, PLL2VCOSEL, PLL2FRACN;
} RCC_PLL2InitTypeDef;
typedef struct {
    uint32_t PLL3M, PLL3N, PLL3P, PLL3Q, PLL3R, PLL3RGE, PLL3VCOSEL, PLL3FRACN;
} RCC_PLL3InitTypeDef;
typedef struct {
    uint32_t PeriphClockSelection, TIMPresSelection;
    RCC_PLL2InitTypeDef PLL2;
    RCC_PLL3InitTypeDef PLL3;
    WB_CLOCK_SELECTIONS
} RCC_PeriphCLKInitTypeDef;
static inline HAL_StatusTypeDef HAL_RCC_OscConfig(const RCC_OscInitTypeDef *init) {
    UNUSED(init);
    return HAL_OK;
}
static inline HAL_StatusTypeDef HAL_RCC_ClockConfig(const RCC_ClkInitTypeDef *init, uint32_t latency) {
    UNUSED(init);
    UNUSED(latency);
    return HAL_OK;
}
static inline HAL_StatusTypeDef HAL_RCCEx_PeriphCLKConfig(const RCC_PeriphCLKInitTypeDef *init) {
    UNUSED(init);
    return HAL_OK;
}
#define HAL_RCC_GetHCLKFreq() SystemCoreClock
#define HAL_RCC_GetPCLK1Freq() (SystemCoreClock / 4)
#define HAL_RCC_GetPCLK2Freq() (SystemCoreClock / 2)
#define HAL_RCC_GetSysClockFreq() SystemCoreClock
WB_SUCCEEDS(HAL_PWREx_EnableOverDrive, void)
#define __HAL_PWR_VOLTAGESCALING_CONFIG(scale) ((void)(scale))
#define __HAL_PWR_GET_FLAG(flag) 1 /* the voltage is there at once */
WB_SUCCEEDS(HAL_PWREx_ConfigSupply, uint32_t supply WB_UNUSED)
WB_SUCCEEDS(HAL_PWREx_ControlVoltageScaling, uint32_t scale WB_UNUSED)
#define HAL_PWREx_EnableBoost() ((void)0)
#define HAL_PWREx_DisableUCPDDeadBattery() ((void)0)
#define HAL_PWR_EnableBkUpAccess() ((void)0)
#define HAL_RCC_EnableCSS() ((void)0)
#define __HAL_RCC_GET_FLAG(flag) ((void)(flag), 0) /* no reset has a cause */
#define __HAL_RCC_CLEAR_RESET_FLAGS() ((void)0)

/* --- pins: outputs go nowhere, inputs read 0 ---------------------------------------------------------------------- */

typedef struct {
    uint32_t nothing;
} GPIO_TypeDef;
typedef struct {
    uint32_t Pin, Mode, Pull, Speed, Alternate;
} GPIO_InitTypeDef;
typedef enum { GPIO_PIN_RESET = 0, GPIO_PIN_SET = 1 } GPIO_PinState;
extern GPIO_TypeDef wb_gpio[8];
#define GPIOA (&wb_gpio[0])
#define GPIOB (&wb_gpio[1])
#define GPIOC (&wb_gpio[2])
#define GPIOD (&wb_gpio[3])
#define GPIOE (&wb_gpio[4])
#define GPIOF (&wb_gpio[5])
#define GPIOG (&wb_gpio[6])
#define GPIOH (&wb_gpio[7])
enum {
    GPIO_PIN_0 = 0x0001, GPIO_PIN_1 = 0x0002, GPIO_PIN_2 = 0x0004, GPIO_PIN_3 = 0x0008, GPIO_PIN_4 = 0x0010,
    GPIO_PIN_5 = 0x0020, GPIO_PIN_6 = 0x0040, GPIO_PIN_7 = 0x0080, GPIO_PIN_8 = 0x0100, GPIO_PIN_9 = 0x0200,
    GPIO_PIN_10 = 0x0400, GPIO_PIN_11 = 0x0800, GPIO_PIN_12 = 0x1000, GPIO_PIN_13 = 0x2000, GPIO_PIN_14 = 0x4000,
    GPIO_PIN_15 = 0x8000,
    GPIO_MODE_INPUT = 0, GPIO_MODE_OUTPUT_PP = 1, GPIO_MODE_AF_PP = 2, GPIO_MODE_ANALOG = 3, GPIO_MODE_OUTPUT_OD = 17,
    GPIO_NOPULL = 0, GPIO_PULLUP = 1, GPIO_PULLDOWN = 2,
    GPIO_SPEED_FREQ_LOW = 0, GPIO_SPEED_FREQ_MEDIUM, GPIO_SPEED_FREQ_HIGH, GPIO_SPEED_FREQ_VERY_HIGH
};
#define HAL_GPIO_Init(port, init) ((void)(port), (void)(init))
#define HAL_GPIO_DeInit(port, pins) ((void)(port), (void)(pins))
#define HAL_GPIO_WritePin(port, pins, state) ((void)(port), (void)(pins), (void)(state))
#define HAL_GPIO_TogglePin(port, pins) ((void)(port), (void)(pins))
#define HAL_GPIO_ReadPin(port, pins) ((void)(port), (void)(pins), GPIO_PIN_RESET)

/* --- watchdog ----------------------------------------------------------------------------------------------------- */

typedef struct {
    void *Instance;
    struct {
        uint32_t Prescaler, Reload, Window;
    } Init;
} IWDG_HandleTypeDef;
enum { IWDG_PRESCALER_4 = 0, IWDG_PRESCALER_8, IWDG_PRESCALER_16, IWDG_PRESCALER_32, IWDG_PRESCALER_64 };
#define IWDG ((void *)0)
static inline HAL_StatusTypeDef HAL_IWDG_Init(IWDG_HandleTypeDef *handle) {
    UNUSED(handle);
    return HAL_OK;
}
static inline HAL_StatusTypeDef HAL_IWDG_Refresh(IWDG_HandleTypeDef *handle) {
    UNUSED(handle);
    return HAL_OK;
}

/* --- UARTs -------------------------------------------------------------------------------------------------------- */

typedef struct {
    uint32_t number;
} USART_TypeDef, UART_TypeDef;
extern USART_TypeDef wb_usart[12];
#define USART1 (&wb_usart[1])
#define USART2 (&wb_usart[2])
#define USART3 (&wb_usart[3])
#define USART4 (&wb_usart[4])
#define USART5 (&wb_usart[5])
#define USART6 (&wb_usart[6])
#define USART7 (&wb_usart[7])
#define USART8 (&wb_usart[8])
#define USART9 (&wb_usart[9])
#define USART10 (&wb_usart[10])
#define LPUART1 (&wb_usart[11])
/* What is a USART on one family is a UART on another. */
#define UART4 USART4
#define UART5 USART5
#define UART7 USART7
#define UART8 USART8
#define UART9 USART9

typedef struct {
    uint32_t BaudRate, WordLength, StopBits, Parity, Mode, HwFlowCtl, OverSampling, OneBitSampling, ClockPrescaler;
} UART_InitTypeDef;
typedef struct {
    uint32_t AdvFeatureInit, RxPinLevelInvert, TxPinLevelInvert, DataInvert, Swap, OverrunDisable, DMADisableonRxError,
        MSBFirst, AutoBaudRateEnable, AutoBaudRateMode;
} UART_AdvFeatureInitTypeDef;
typedef struct {
    void *Instance, *Parent;
    struct {
        uint32_t Channel, Request, Direction, PeriphInc, MemInc, PeriphDataAlignment, MemDataAlignment, Mode, Priority, FIFOMode,
            FIFOThreshold, MemBurst, PeriphBurst;
    } Init;
    uint8_t wb_no_half;
} DMA_HandleTypeDef;
typedef uint32_t HAL_UART_StateTypeDef, HAL_UART_RxEventTypeTypeDef;
enum {
    HAL_UART_STATE_RESET = 0, HAL_UART_STATE_READY = 0x20, HAL_UART_STATE_BUSY_TX = 0x21, HAL_UART_STATE_BUSY_RX = 0x22
};
typedef struct __UART_HandleTypeDef {
    USART_TypeDef *Instance;
    UART_InitTypeDef Init;
    UART_AdvFeatureInitTypeDef AdvancedInit;
    const uint8_t *pTxBuffPtr;
    uint16_t TxXferSize;
    __IO uint16_t TxXferCount;
    uint8_t *pRxBuffPtr;
    uint16_t RxXferSize;
    __IO uint16_t RxXferCount;
    __IO uint32_t ReceptionType;
    DMA_HandleTypeDef *hdmatx, *hdmarx;
    HAL_LockTypeDef Lock;
    __IO HAL_UART_StateTypeDef gState, RxState;
    __IO uint32_t ErrorCode;
    __IO HAL_UART_RxEventTypeTypeDef RxEventType;
    void (*RxCpltCallback)(struct __UART_HandleTypeDef *uart);
    void (*RxHalfCpltCallback)(struct __UART_HandleTypeDef *uart);
    void (*TxCpltCallback)(struct __UART_HandleTypeDef *uart);
    void (*RxEventCallback)(struct __UART_HandleTypeDef *uart, uint16_t size);
    uint8_t wb_by_dma, wb_to_idle, wb_sent, wb_asks_idle, wb_is_idle;
} UART_HandleTypeDef;
typedef enum {
    HAL_UART_TX_HALFCOMPLETE_CB_ID = 0, HAL_UART_TX_COMPLETE_CB_ID, HAL_UART_RX_HALFCOMPLETE_CB_ID, HAL_UART_RX_COMPLETE_CB_ID,
    HAL_UART_ERROR_CB_ID, HAL_UART_ABORT_COMPLETE_CB_ID, HAL_UART_ABORT_TRANSMIT_COMPLETE_CB_ID,
    HAL_UART_ABORT_RECEIVE_COMPLETE_CB_ID, HAL_UART_MSPINIT_CB_ID = 11, HAL_UART_MSPDEINIT_CB_ID
} HAL_UART_CallbackIDTypeDef;
enum {
    UART_WORDLENGTH_8B = 0, UART_WORDLENGTH_9B = 0x1000, UART_STOPBITS_1 = 0, UART_STOPBITS_2 = 0x2000,
    UART_PARITY_NONE = 0, UART_PARITY_EVEN = 0x400, UART_PARITY_ODD = 0x600, UART_HWCONTROL_NONE = 0,
    UART_MODE_RX = 4, UART_MODE_TX = 8, UART_MODE_TX_RX = 12, UART_OVERSAMPLING_16 = 0, UART_OVERSAMPLING_8 = 0x8000,
    HAL_UART_ERROR_NONE = 0, HAL_UART_ERROR_ORE = 8, HAL_UART_RECEPTION_STANDARD = 0, HAL_UART_RECEPTION_TOIDLE = 1,
    HAL_UART_RXEVENT_TC = 0, HAL_UART_RXEVENT_HT = 1, HAL_UART_RXEVENT_IDLE = 2,
    UART_IT_RXNE = 0x20, UART_IT_IDLE = 0x10, UART_FLAG_ORE = 8, UART_FLAG_IDLE = 0x10, UART_FLAG_RXNE = 0x20,
    UART_FLAG_PE = 1, UART_FLAG_FE = 2, UART_FLAG_NE = 4, UART_FLAG_TC = 0x40, UART_FLAG_TXE = 0x80, UART_IT_TC = 0x40, UART_IT_TXE = 0x80,
    UART_IT_PE = 0x100, UART_IT_ERR = 0x200, UART_CLEAR_PEF = 1, UART_CLEAR_FEF = 2, UART_CLEAR_NEF = 4, UART_CLEAR_OREF = 8, UART_CLEAR_IDLEF = 0x10,
    DMA_IT_HT = 8, DMA_IT_TC = 16, DMA_NORMAL = 0, DMA_CIRCULAR = 0x100
};
WB_SUCCEEDS(HAL_UARTEx_SetTxFifoThreshold, UART_HandleTypeDef *uart WB_UNUSED, uint32_t level WB_UNUSED)
WB_SUCCEEDS(HAL_UARTEx_SetRxFifoThreshold, UART_HandleTypeDef *uart WB_UNUSED, uint32_t level WB_UNUSED)
WB_SUCCEEDS(HAL_UARTEx_EnableFifoMode, UART_HandleTypeDef *uart WB_UNUSED)
WB_SUCCEEDS(HAL_UARTEx_DisableFifoMode, UART_HandleTypeDef *uart WB_UNUSED)
/* Of a UART's own interrupts, in USART1_IRQHandler and the like, the idle line's comes. */
#define __HAL_UART_ENABLE_IT(handle, which) ((which) == UART_IT_IDLE ? (void)((handle)->wb_asks_idle = 1) : (void)0)
#define __HAL_UART_DISABLE_IT(handle, which) ((which) == UART_IT_IDLE ? (void)((handle)->wb_asks_idle = 0) : (void)0)
#define __HAL_UART_GET_IT_SOURCE(handle, which) ((which) == UART_IT_IDLE && (handle)->wb_asks_idle ? SET : RESET)
#define __HAL_UART_GET_FLAG(handle, which) wb_uart_flag(handle, which)
#define __HAL_UART_CLEAR_FLAG(handle, which) ((which) & UART_FLAG_IDLE ? (void)((handle)->wb_is_idle = 0) : (void)0)
#define __HAL_UART_CLEAR_IT(handle, which) __HAL_UART_CLEAR_FLAG(handle, which)
FlagStatus wb_uart_flag(const UART_HandleTypeDef *uart, uint32_t which);
#define __HAL_UART_CLEAR_OREFLAG(handle) ((void)(handle))
#define __HAL_UART_CLEAR_IDLEFLAG(handle) ((void)((handle)->wb_is_idle = 0))
#define __HAL_UART_CLEAR_PEFLAG(handle) ((void)(handle))
#define __HAL_UART_CLEAR_FEFLAG(handle) ((void)(handle))
#define __HAL_UART_CLEAR_NEFLAG(handle) ((void)(handle))
#define __HAL_UART_ENABLE(handle) ((void)(handle))
#define __HAL_UART_DISABLE(handle) ((void)(handle))
#define __HAL_DMA_DISABLE_IT(handle, which) wb_dma_tells(handle, which, 0)
#define __HAL_DMA_ENABLE_IT(handle, which) wb_dma_tells(handle, which, 1)
static inline void wb_dma_tells(DMA_HandleTypeDef *dma, uint32_t which, int on) {
    if (dma && (which & DMA_IT_HT))
        dma->wb_no_half = !on;
}
#define __HAL_LINKDMA(handle, field, dma) ((handle)->field = &(dma))

HAL_StatusTypeDef HAL_UART_Init(UART_HandleTypeDef *uart);
HAL_StatusTypeDef HAL_UART_DeInit(UART_HandleTypeDef *uart);
HAL_StatusTypeDef HAL_UART_Transmit(UART_HandleTypeDef *uart, const uint8_t *data, uint16_t size, uint32_t timeout);
HAL_StatusTypeDef HAL_UART_Transmit_IT(UART_HandleTypeDef *uart, const uint8_t *data, uint16_t size);
HAL_StatusTypeDef HAL_UART_Transmit_DMA(UART_HandleTypeDef *uart, const uint8_t *data, uint16_t size);
HAL_StatusTypeDef HAL_UART_Receive(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size, uint32_t timeout);
HAL_StatusTypeDef HAL_UART_Receive_IT(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size);
HAL_StatusTypeDef HAL_UART_Receive_DMA(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size);
HAL_StatusTypeDef HAL_UARTEx_ReceiveToIdle_IT(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size);
HAL_StatusTypeDef HAL_UARTEx_ReceiveToIdle_DMA(UART_HandleTypeDef *uart, uint8_t *data, uint16_t size);
HAL_StatusTypeDef HAL_UART_AbortReceive(UART_HandleTypeDef *uart);
HAL_StatusTypeDef HAL_UART_AbortReceive_IT(UART_HandleTypeDef *uart);
HAL_StatusTypeDef HAL_UART_DMAStop(UART_HandleTypeDef *uart);
HAL_UART_RxEventTypeTypeDef HAL_UARTEx_GetRxEventType(const UART_HandleTypeDef *uart);
HAL_StatusTypeDef HAL_UART_RegisterCallback(
    UART_HandleTypeDef *uart, HAL_UART_CallbackIDTypeDef which, void (*call)(UART_HandleTypeDef *));
HAL_StatusTypeDef HAL_UART_RegisterRxEventCallback(
    UART_HandleTypeDef *uart, void (*call)(UART_HandleTypeDef *, uint16_t));
HAL_StatusTypeDef HAL_UART_Abort(UART_HandleTypeDef *uart);
#define HAL_UART_GetError(uart) ((uart)->ErrorCode)
HAL_UART_StateTypeDef HAL_UART_GetState(const UART_HandleTypeDef *uart);
void HAL_UART_IRQHandler(UART_HandleTypeDef *uart);
/* The firmware's own: */
void HAL_UART_RxCpltCallback(UART_HandleTypeDef *uart);
void HAL_UART_RxHalfCpltCallback(UART_HandleTypeDef *uart);
void HAL_UART_TxCpltCallback(UART_HandleTypeDef *uart);
void HAL_UART_ErrorCallback(UART_HandleTypeDef *uart);
void HAL_UARTEx_RxEventCallback(UART_HandleTypeDef *uart, uint16_t size);

/* --- CAN ---------------------------------------------------------------------------------------------------------- */

typedef struct {
    uint32_t number;
} CAN_TypeDef;
extern CAN_TypeDef wb_can_instance[4];
#define CAN (&wb_can_instance[1])
#define CAN1 (&wb_can_instance[1])
#define CAN2 (&wb_can_instance[2])
#define CAN3 (&wb_can_instance[3])

typedef struct {
    uint32_t Prescaler, Mode, SyncJumpWidth, TimeSeg1, TimeSeg2;
    FunctionalState TimeTriggeredMode, AutoBusOff, AutoWakeUp, AutoRetransmission, ReceiveFifoLocked, TransmitFifoPriority;
} CAN_InitTypeDef;
typedef struct __CAN_HandleTypeDef {
    CAN_TypeDef *Instance;
    CAN_InitTypeDef Init;
    __IO uint32_t State, ErrorCode;
    void (*RxFifo0MsgPendingCallback)(struct __CAN_HandleTypeDef *can);
    void (*RxFifo1MsgPendingCallback)(struct __CAN_HandleTypeDef *can);
    void (*TxMailbox0CompleteCallback)(struct __CAN_HandleTypeDef *can);
    void (*TxMailbox1CompleteCallback)(struct __CAN_HandleTypeDef *can);
    void (*TxMailbox2CompleteCallback)(struct __CAN_HandleTypeDef *can);
    uint32_t wb_notifications, wb_sent;
} CAN_HandleTypeDef;
typedef enum {
    HAL_CAN_TX_MAILBOX0_COMPLETE_CB_ID = 0, HAL_CAN_TX_MAILBOX1_COMPLETE_CB_ID, HAL_CAN_TX_MAILBOX2_COMPLETE_CB_ID,
    HAL_CAN_RX_FIFO0_MSG_PENDING_CB_ID = 6, HAL_CAN_RX_FIFO0_FULL_CB_ID, HAL_CAN_RX_FIFO1_MSG_PENDING_CB_ID,
    HAL_CAN_RX_FIFO1_FULL_CB_ID, HAL_CAN_ERROR_CB_ID = 12
} HAL_CAN_CallbackIDTypeDef;
typedef struct {
    uint32_t StdId, ExtId, IDE, RTR, DLC;
    FunctionalState TransmitGlobalTime;
} CAN_TxHeaderTypeDef;
typedef struct {
    uint32_t StdId, ExtId, IDE, RTR, DLC, Timestamp, FilterMatchIndex;
} CAN_RxHeaderTypeDef;
typedef struct {
    uint32_t FilterIdHigh, FilterIdLow, FilterMaskIdHigh, FilterMaskIdLow, FilterFIFOAssignment, FilterBank, FilterMode,
        FilterScale, FilterActivation, SlaveStartFilterBank;
} CAN_FilterTypeDef;
enum {
    CAN_ID_STD = 0, CAN_ID_EXT = 4, CAN_RTR_DATA = 0, CAN_RTR_REMOTE = 2, CAN_RX_FIFO0 = 0, CAN_RX_FIFO1 = 1,
    CAN_FILTER_FIFO0 = 0, CAN_FILTER_FIFO1 = 1, CAN_FILTERMODE_IDMASK = 0, CAN_FILTERMODE_IDLIST = 1,
    CAN_FILTERSCALE_16BIT = 0, CAN_FILTERSCALE_32BIT = 1, CAN_FILTER_DISABLE = 0, CAN_FILTER_ENABLE = 1,
    CAN_IT_TX_MAILBOX_EMPTY = 1, CAN_IT_RX_FIFO0_MSG_PENDING = 2, CAN_IT_RX_FIFO1_MSG_PENDING = 16, CAN_IT_BUSOFF = 0x400,
    CAN_IT_ERROR = 0x8000, CAN_IT_RX_FIFO0_FULL = 4, CAN_IT_RX_FIFO0_OVERRUN = 8, CAN_IT_RX_FIFO1_FULL = 32,
    CAN_IT_RX_FIFO1_OVERRUN = 64, CAN_IT_WAKEUP = 0x10000, CAN_IT_LAST_ERROR_CODE = 0x800, CAN_IT_ERROR_WARNING = 0x100, CAN_IT_ERROR_PASSIVE = 0x200,
    CAN_TX_MAILBOX0 = 1, CAN_TX_MAILBOX1 = 2, CAN_TX_MAILBOX2 = 4,
    CAN_MODE_NORMAL = 0, CAN_MODE_LOOPBACK = 0x40000000, CAN_SJW_1TQ = 0, CAN_SJW_2TQ = 0x1000000,
    CAN_BS1_1TQ = 0, CAN_BS1_6TQ = 5 << 16, CAN_BS1_9TQ = 8 << 16, CAN_BS1_10TQ = 9 << 16, CAN_BS1_11TQ = 10 << 16,
    CAN_BS1_13TQ = 12 << 16, CAN_BS2_1TQ = 0, CAN_BS2_2TQ = 1 << 20, CAN_BS2_3TQ = 2 << 20, CAN_BS2_4TQ = 3 << 20,
    HAL_CAN_STATE_RESET = 0, HAL_CAN_STATE_READY = 1, HAL_CAN_STATE_LISTENING = 2, HAL_CAN_ERROR_NONE = 0
};

HAL_StatusTypeDef HAL_CAN_Init(CAN_HandleTypeDef *can);
HAL_StatusTypeDef HAL_CAN_ConfigFilter(CAN_HandleTypeDef *can, const CAN_FilterTypeDef *filter);
HAL_StatusTypeDef HAL_CAN_Start(CAN_HandleTypeDef *can);
HAL_StatusTypeDef HAL_CAN_Stop(CAN_HandleTypeDef *can);
HAL_StatusTypeDef HAL_CAN_ActivateNotification(CAN_HandleTypeDef *can, uint32_t which);
HAL_StatusTypeDef HAL_CAN_DeactivateNotification(CAN_HandleTypeDef *can, uint32_t which);
HAL_StatusTypeDef HAL_CAN_AddTxMessage(
    CAN_HandleTypeDef *can, const CAN_TxHeaderTypeDef *header, const uint8_t data[], uint32_t *mailbox);
HAL_StatusTypeDef HAL_CAN_GetRxMessage(CAN_HandleTypeDef *can, uint32_t fifo, CAN_RxHeaderTypeDef *header, uint8_t data[]);
uint32_t HAL_CAN_GetTxMailboxesFreeLevel(const CAN_HandleTypeDef *can);
uint32_t HAL_CAN_GetRxFifoFillLevel(const CAN_HandleTypeDef *can, uint32_t fifo);
uint32_t HAL_CAN_IsTxMessagePending(const CAN_HandleTypeDef *can, uint32_t mailboxes);
uint32_t HAL_CAN_GetState(const CAN_HandleTypeDef *can);
uint32_t HAL_CAN_GetError(const CAN_HandleTypeDef *can);
WB_SUCCEEDS(HAL_CAN_ResetError, CAN_HandleTypeDef *can WB_UNUSED)
WB_SUCCEEDS(HAL_CAN_AbortTxRequest, CAN_HandleTypeDef *can WB_UNUSED, uint32_t mailboxes WB_UNUSED)
HAL_StatusTypeDef HAL_CAN_RegisterCallback(
    CAN_HandleTypeDef *can, HAL_CAN_CallbackIDTypeDef which, void (*call)(CAN_HandleTypeDef *));
void HAL_CAN_IRQHandler(CAN_HandleTypeDef *can);
/* The firmware's own: */
void HAL_CAN_RxFifo0MsgPendingCallback(CAN_HandleTypeDef *can);
void HAL_CAN_RxFifo1MsgPendingCallback(CAN_HandleTypeDef *can);
void HAL_CAN_TxMailbox0CompleteCallback(CAN_HandleTypeDef *can);
void HAL_CAN_TxMailbox1CompleteCallback(CAN_HandleTypeDef *can);
void HAL_CAN_TxMailbox2CompleteCallback(CAN_HandleTypeDef *can);
void HAL_CAN_ErrorCallback(CAN_HandleTypeDef *can);

/* --- FDCAN, for classic frames ------------------------------------------------------------------------------------ */

typedef struct {
    uint32_t number;
} FDCAN_GlobalTypeDef;
extern FDCAN_GlobalTypeDef wb_fdcan_instance[4];
#define FDCAN1 (&wb_fdcan_instance[1])
#define FDCAN2 (&wb_fdcan_instance[2])
#define FDCAN3 (&wb_fdcan_instance[3])

typedef struct {
    uint32_t ClockDivider, FrameFormat, Mode;
    FunctionalState AutoRetransmission, TransmitPause, ProtocolException;
    uint32_t NominalPrescaler, NominalSyncJumpWidth, NominalTimeSeg1, NominalTimeSeg2, DataPrescaler, DataSyncJumpWidth,
        DataTimeSeg1, DataTimeSeg2, MessageRAMOffset, StdFiltersNbr, ExtFiltersNbr, RxFifo0ElmtsNbr, RxFifo0ElmtSize,
        RxFifo1ElmtsNbr, RxFifo1ElmtSize, RxBuffersNbr, RxBufferSize, TxEventsNbr, TxBuffersNbr, TxFifoQueueElmtsNbr,
        TxFifoQueueMode, TxElmtSize;
} FDCAN_InitTypeDef;
typedef struct __FDCAN_HandleTypeDef {
    FDCAN_GlobalTypeDef *Instance;
    FDCAN_InitTypeDef Init;
    __IO uint32_t State, ErrorCode;
    void (*RxFifo0Callback)(struct __FDCAN_HandleTypeDef *can, uint32_t which);
    void (*RxFifo1Callback)(struct __FDCAN_HandleTypeDef *can, uint32_t which);
    uint32_t wb_notifications;
} FDCAN_HandleTypeDef;
typedef struct {
    uint32_t Identifier, IdType, TxFrameType, DataLength, ErrorStateIndicator, BitRateSwitch, FDFormat, TxEventFifoControl,
        MessageMarker;
} FDCAN_TxHeaderTypeDef;
typedef struct {
    uint32_t Identifier, IdType, RxFrameType, DataLength, ErrorStateIndicator, BitRateSwitch, FDFormat, RxTimestamp,
        FilterIndex, IsFilterMatchingFrame;
} FDCAN_RxHeaderTypeDef;
typedef struct {
    uint32_t IdType, FilterIndex, FilterType, FilterConfig, FilterID1, FilterID2, RxBufferIndex, IsCalibrationMsg;
} FDCAN_FilterTypeDef;
enum {
    FDCAN_STANDARD_ID = 0, FDCAN_EXTENDED_ID = 0x40000000, FDCAN_DATA_FRAME = 0, FDCAN_REMOTE_FRAME = 0x20000000,
    FDCAN_DLC_BYTES_0 = 0, FDCAN_DLC_BYTES_1, FDCAN_DLC_BYTES_2, FDCAN_DLC_BYTES_3, FDCAN_DLC_BYTES_4, FDCAN_DLC_BYTES_5,
    FDCAN_DLC_BYTES_6, FDCAN_DLC_BYTES_7, FDCAN_DLC_BYTES_8, FDCAN_DLC_BYTES_12, FDCAN_DLC_BYTES_16, FDCAN_DLC_BYTES_20,
    FDCAN_DLC_BYTES_24, FDCAN_DLC_BYTES_32, FDCAN_DLC_BYTES_48, FDCAN_DLC_BYTES_64, FDCAN_ESI_ACTIVE = 0, FDCAN_BRS_OFF = 0, FDCAN_BRS_ON = 0x100000,
    FDCAN_ESI_PASSIVE = 0x80000000, FDCAN_CLASSIC_CAN = 0,
    FDCAN_FD_CAN = 0x200000, FDCAN_NO_TX_EVENTS = 0, FDCAN_STORE_TX_EVENTS = 0x800000, FDCAN_RX_FIFO0 = 0x40, FDCAN_RX_FIFO1 = 0x41,
    FDCAN_IT_RX_FIFO0_NEW_MESSAGE = 1, FDCAN_IT_RX_FIFO1_NEW_MESSAGE = 0x10, FDCAN_IT_BUS_OFF = 0x2000000, FDCAN_IT_RX_FIFO0_FULL = 4,
    FDCAN_IT_RX_FIFO1_FULL = 0x40, FDCAN_IT_RX_FIFO0_WATERMARK = 2, FDCAN_IT_RX_FIFO1_WATERMARK = 0x20,
    FDCAN_IT_RX_FIFO0_MESSAGE_LOST = 8, FDCAN_IT_RX_FIFO1_MESSAGE_LOST = 0x80, FDCAN_IT_TX_COMPLETE = 0x200,
    FDCAN_IT_TX_FIFO_EMPTY = 0x800, FDCAN_IT_ERROR_PASSIVE = 0x800000, FDCAN_IT_ERROR_WARNING = 0x1000000,
    FDCAN_CFG_RX_FIFO0 = 0, FDCAN_CFG_RX_FIFO1 = 1, FDCAN_RX_FIFO_BLOCKING = 0, FDCAN_RX_FIFO_OVERWRITE = 1,
    FDCAN_FILTER_RANGE = 0, FDCAN_FILTER_DUAL = 1, FDCAN_FILTER_MASK = 2, FDCAN_FILTER_DISABLE = 0,
    FDCAN_FILTER_TO_RXFIFO0 = 1, FDCAN_FILTER_TO_RXFIFO1 = 2, FDCAN_ACCEPT_IN_RX_FIFO0 = 0, FDCAN_ACCEPT_IN_RX_FIFO1 = 1,
    FDCAN_REJECT = 2, FDCAN_FILTER_REMOTE = 0, FDCAN_REJECT_REMOTE = 1, FDCAN_FRAME_CLASSIC = 0, FDCAN_FRAME_FD_NO_BRS = 0x100, FDCAN_FRAME_FD_BRS = 0x300, FDCAN_MODE_NORMAL = 0,
    FDCAN_TX_FIFO_OPERATION = 0, FDCAN_TX_QUEUE_OPERATION = 0x1000000, FDCAN_CLOCK_DIV1 = 0, FDCAN_DATA_BYTES_8 = 4
};
HAL_StatusTypeDef HAL_FDCAN_Init(FDCAN_HandleTypeDef *can);
HAL_StatusTypeDef HAL_FDCAN_ConfigFilter(FDCAN_HandleTypeDef *can, const FDCAN_FilterTypeDef *filter);
HAL_StatusTypeDef HAL_FDCAN_ConfigGlobalFilter(
    FDCAN_HandleTypeDef *can, uint32_t standard, uint32_t extended, uint32_t remote_standard, uint32_t remote_extended);
HAL_StatusTypeDef HAL_FDCAN_Start(FDCAN_HandleTypeDef *can);
HAL_StatusTypeDef HAL_FDCAN_Stop(FDCAN_HandleTypeDef *can);
HAL_StatusTypeDef HAL_FDCAN_ActivateNotification(FDCAN_HandleTypeDef *can, uint32_t which, uint32_t buffers);
HAL_StatusTypeDef HAL_FDCAN_AddMessageToTxFifoQ(
    FDCAN_HandleTypeDef *can, const FDCAN_TxHeaderTypeDef *header, const uint8_t *data);
HAL_StatusTypeDef HAL_FDCAN_GetRxMessage(
    FDCAN_HandleTypeDef *can, uint32_t fifo, FDCAN_RxHeaderTypeDef *header, uint8_t *data);
uint32_t HAL_FDCAN_GetTxFifoFreeLevel(const FDCAN_HandleTypeDef *can);
uint32_t HAL_FDCAN_GetRxFifoFillLevel(const FDCAN_HandleTypeDef *can, uint32_t fifo);
HAL_StatusTypeDef HAL_FDCAN_RegisterRxFifo0Callback(
    FDCAN_HandleTypeDef *can, void (*call)(FDCAN_HandleTypeDef *, uint32_t));
HAL_StatusTypeDef HAL_FDCAN_RegisterRxFifo1Callback(
    FDCAN_HandleTypeDef *can, void (*call)(FDCAN_HandleTypeDef *, uint32_t));
WB_SUCCEEDS(HAL_FDCAN_ConfigFifoWatermark, FDCAN_HandleTypeDef *can WB_UNUSED, uint32_t fifo WB_UNUSED, uint32_t level WB_UNUSED)
WB_SUCCEEDS(HAL_FDCAN_ConfigRxFifoOverwrite, FDCAN_HandleTypeDef *can WB_UNUSED, uint32_t fifo WB_UNUSED, uint32_t mode WB_UNUSED)
WB_SUCCEEDS(HAL_FDCAN_ConfigTxDelayCompensation, FDCAN_HandleTypeDef *can WB_UNUSED, uint32_t offset WB_UNUSED,
            uint32_t filter WB_UNUSED)
WB_SUCCEEDS(HAL_FDCAN_EnableTxDelayCompensation, FDCAN_HandleTypeDef *can WB_UNUSED)
void HAL_FDCAN_IRQHandler(FDCAN_HandleTypeDef *can);
/* The firmware's own: */
void HAL_FDCAN_RxFifo0Callback(FDCAN_HandleTypeDef *can, uint32_t which);
void HAL_FDCAN_RxFifo1Callback(FDCAN_HandleTypeDef *can, uint32_t which);

/* --- timers ------------------------------------------------------------------------------------------------------- */

typedef struct {
    uint32_t number;
} TIM_TypeDef;
extern TIM_TypeDef wb_tim[25];
#define TIM1 (&wb_tim[1])
#define TIM2 (&wb_tim[2])
#define TIM3 (&wb_tim[3])
#define TIM4 (&wb_tim[4])
#define TIM5 (&wb_tim[5])
#define TIM6 (&wb_tim[6])
#define TIM7 (&wb_tim[7])
#define TIM8 (&wb_tim[8])
#define TIM9 (&wb_tim[9])
#define TIM10 (&wb_tim[10])
#define TIM11 (&wb_tim[11])
#define TIM12 (&wb_tim[12])
#define TIM13 (&wb_tim[13])
#define TIM14 (&wb_tim[14])
#define TIM15 (&wb_tim[15])
#define TIM16 (&wb_tim[16])
#define TIM17 (&wb_tim[17])
#define TIM18 (&wb_tim[18])
#define TIM19 (&wb_tim[19])
#define TIM20 (&wb_tim[20])
#define TIM21 (&wb_tim[21])
#define TIM22 (&wb_tim[22])
#define TIM23 (&wb_tim[23])
#define TIM24 (&wb_tim[24])

typedef struct __TIM_HandleTypeDef {
    TIM_TypeDef *Instance;
    struct {
        uint32_t Prescaler, CounterMode, Period, ClockDivision, RepetitionCounter, AutoReloadPreload;
        WB_TIM_INIT
    } Init;
    void (*PeriodElapsedCallback)(struct __TIM_HandleTypeDef *timer);
    uint32_t wb_running;
} TIM_HandleTypeDef;
typedef enum { HAL_TIM_PERIOD_ELAPSED_CB_ID = 14 } HAL_TIM_CallbackIDTypeDef;
typedef struct {
    uint32_t MasterOutputTrigger, MasterOutputTrigger2, MasterSlaveMode;
} TIM_MasterConfigTypeDef;
enum {
    TIM_COUNTERMODE_UP = 0, TIM_CLOCKDIVISION_DIV1 = 0, TIM_AUTORELOAD_PRELOAD_DISABLE = 0, TIM_AUTORELOAD_PRELOAD_ENABLE = 0x80,
    TIM_TRGO_RESET = 0, TIM_MASTERSLAVEMODE_DISABLE = 0
};
static inline HAL_StatusTypeDef HAL_TIMEx_MasterConfigSynchronization(TIM_HandleTypeDef *timer, const TIM_MasterConfigTypeDef *set) {
    UNUSED(timer);
    UNUSED(set);
    return HAL_OK;
}
HAL_StatusTypeDef HAL_TIM_Base_Init(TIM_HandleTypeDef *timer);
HAL_StatusTypeDef HAL_TIM_Base_Start_IT(TIM_HandleTypeDef *timer);
HAL_StatusTypeDef HAL_TIM_Base_Stop_IT(TIM_HandleTypeDef *timer);
HAL_StatusTypeDef HAL_TIM_RegisterCallback(
    TIM_HandleTypeDef *timer, HAL_TIM_CallbackIDTypeDef which, void (*call)(TIM_HandleTypeDef *));
void HAL_TIM_IRQHandler(TIM_HandleTypeDef *timer);
/* The firmware's own: */
void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *timer);

#ifdef __cplusplus
}
#endif

#include "wheelbench_board.h"
#endif
