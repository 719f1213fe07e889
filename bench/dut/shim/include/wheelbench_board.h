/* What a generator's own files set up beside UARTs, CAN and timers: DMA, ADC, SPI, I2C, PWM, encoders, the cycle counter.
 *
 * All of it compiles and succeeds. Nothing is connected: outputs go nowhere, what is read is 0, with a note in the output;
 * what shall be read instead goes into wheelbench_port.c, as a function of the same name. The cycle counter runs in virtual
 * time, as everything does.
 *
 * Written from the interface's public documentation; nothing is copied from it. MIT licence.
 */
#ifndef WHEELBENCH_BOARD_H
#define WHEELBENCH_BOARD_H

#ifdef __cplusplus
extern "C" {
#endif

/* Of a handle that is given to it, such a call says that all is well. */
#define WB_SUCCEEDS(name, ...) \
    static inline HAL_StatusTypeDef name(__VA_ARGS__) { \
        return HAL_OK; \
    }
#define WB_DOES_NOTHING(name, ...) \
    static inline void name(__VA_ARGS__) {}
#define WB_UNUSED __attribute__((unused))

/* --- the cycle counter -------------------------------------------------------------------------------------------- */

typedef struct {
    __IO uint32_t CTRL, CYCCNT;
} DWT_Type;
typedef struct {
    __IO uint32_t DEMCR;
} CoreDebug_Type;
DWT_Type *wb_dwt(void);
extern CoreDebug_Type wb_core_debug;
#define DWT wb_dwt()
#define CoreDebug (&wb_core_debug)
#define DWT_CTRL_CYCCNTENA_Msk 1U
#define CoreDebug_DEMCR_TRCENA_Msk (1U << 24)

/* --- clocks and pins of more peripherals -------------------------------------------------------------------------- */

#define __HAL_RCC_UART4_CLK_ENABLE() ((void)0)
#define __HAL_RCC_UART5_CLK_ENABLE() ((void)0)
#define __HAL_RCC_UART7_CLK_ENABLE() ((void)0)
#define __HAL_RCC_UART8_CLK_ENABLE() ((void)0)
#define __HAL_RCC_FDCAN_CLK_ENABLE() ((void)0)
#define __HAL_RCC_DMAMUX1_CLK_ENABLE() ((void)0)
#define __HAL_RCC_CRC_CLK_ENABLE() ((void)0)
#define __HAL_RCC_TIM1_CLK_ENABLE() ((void)0)
#define __HAL_RCC_TIM2_CLK_ENABLE() ((void)0)
#define __HAL_RCC_TIM3_CLK_ENABLE() ((void)0)
#define __HAL_RCC_TIM4_CLK_ENABLE() ((void)0)
#define __HAL_RCC_TIM5_CLK_ENABLE() ((void)0)
#define __HAL_RCC_TIM6_CLK_ENABLE() ((void)0)
#define __HAL_RCC_TIM7_CLK_ENABLE() ((void)0)
#define __HAL_RCC_TIM8_CLK_ENABLE() ((void)0)
#define __HAL_RCC_TIM12_CLK_ENABLE() ((void)0)
#define __HAL_RCC_ADC1_CLK_ENABLE() ((void)0)
#define __HAL_RCC_ADC2_CLK_ENABLE() ((void)0)
#define __HAL_RCC_ADC3_CLK_ENABLE() ((void)0)
#define __HAL_RCC_ADC12_CLK_ENABLE() ((void)0)
#define __HAL_RCC_SPI1_CLK_ENABLE() ((void)0)
#define __HAL_RCC_SPI2_CLK_ENABLE() ((void)0)
#define __HAL_RCC_SPI3_CLK_ENABLE() ((void)0)
#define __HAL_RCC_I2C1_CLK_ENABLE() ((void)0)
#define __HAL_RCC_I2C2_CLK_ENABLE() ((void)0)
#define __HAL_RCC_I2C3_CLK_ENABLE() ((void)0)
enum {
    GPIO_AF1_TIM1 = 1, GPIO_AF1_TIM2 = 1, GPIO_AF2_TIM3 = 2, GPIO_AF2_TIM4 = 2, GPIO_AF2_TIM5 = 2, GPIO_AF3_TIM8 = 3,
    GPIO_AF4_I2C1 = 4, GPIO_AF4_I2C2 = 4, GPIO_AF4_I2C3 = 4, GPIO_AF5_SPI1 = 5, GPIO_AF5_SPI2 = 5, GPIO_AF6_SPI3 = 6,
    GPIO_AF8_UART4 = 8, GPIO_AF8_UART5 = 8, GPIO_AF8_UART7 = 8, GPIO_AF8_UART8 = 8, GPIO_AF9_FDCAN1 = 9, GPIO_AF9_TIM12 = 9,
    GPIO_MODE_AF_OD = 18, GPIO_MODE_IT_RISING = 0x110000, GPIO_MODE_IT_FALLING = 0x210000,
    GPIO_MODE_IT_RISING_FALLING = 0x310000
};

/* --- DMA: of a UART it is the UART's; nothing else has any -------------------------------------------------------- */

#define DMA1_Stream0 ((void *)0)
#define DMA1_Stream1 ((void *)0)
#define DMA1_Stream2 ((void *)0)
#define DMA1_Stream3 ((void *)0)
#define DMA1_Stream4 ((void *)0)
#define DMA1_Stream5 ((void *)0)
#define DMA1_Stream6 ((void *)0)
#define DMA1_Stream7 ((void *)0)
#define DMA2_Stream0 ((void *)0)
#define DMA2_Stream1 ((void *)0)
#define DMA2_Stream2 ((void *)0)
#define DMA2_Stream3 ((void *)0)
#define DMA2_Stream4 ((void *)0)
#define DMA2_Stream5 ((void *)0)
#define DMA2_Stream6 ((void *)0)
#define DMA2_Stream7 ((void *)0)
#define DMA1_Channel1 ((void *)0)
#define DMA1_Channel2 ((void *)0)
#define DMA1_Channel3 ((void *)0)
#define DMA1_Channel4 ((void *)0)
#define DMA1_Channel5 ((void *)0)
#define DMA1_Channel6 ((void *)0)
#define DMA1_Channel7 ((void *)0)
enum {
    DMA_CHANNEL_0 = 0, DMA_CHANNEL_1, DMA_CHANNEL_2, DMA_CHANNEL_3, DMA_CHANNEL_4, DMA_CHANNEL_5, DMA_CHANNEL_6, DMA_CHANNEL_7,
    DMA_REQUEST_USART1_RX = 0, DMA_REQUEST_USART1_TX, DMA_REQUEST_USART2_RX, DMA_REQUEST_USART2_TX, DMA_REQUEST_USART3_RX,
    DMA_REQUEST_USART3_TX, DMA_REQUEST_UART4_RX, DMA_REQUEST_UART4_TX, DMA_REQUEST_UART5_RX, DMA_REQUEST_UART5_TX,
    DMA_REQUEST_USART6_RX, DMA_REQUEST_USART6_TX, DMA_REQUEST_ADC1,
    DMA_PERIPH_TO_MEMORY = 0, DMA_MEMORY_TO_PERIPH = 0x40, DMA_MEMORY_TO_MEMORY = 0x80, DMA_PINC_DISABLE = 0,
    DMA_PINC_ENABLE = 0x200, DMA_MINC_DISABLE = 0, DMA_MINC_ENABLE = 0x400, DMA_PDATAALIGN_BYTE = 0,
    DMA_PDATAALIGN_HALFWORD = 0x800, DMA_PDATAALIGN_WORD = 0x1000, DMA_MDATAALIGN_BYTE = 0, DMA_MDATAALIGN_HALFWORD = 0x2000,
    DMA_MDATAALIGN_WORD = 0x4000, DMA_PRIORITY_LOW = 0, DMA_PRIORITY_MEDIUM, DMA_PRIORITY_HIGH, DMA_PRIORITY_VERY_HIGH,
    DMA_FIFOMODE_DISABLE = 0, DMA_FIFOMODE_ENABLE = 4,
    DMA1_Stream0_IRQn = 11, DMA1_Stream1_IRQn, DMA1_Stream2_IRQn, DMA1_Stream3_IRQn, DMA1_Stream4_IRQn, DMA1_Stream5_IRQn,
    DMA1_Stream6_IRQn, ADC_IRQn = 18, TIM1_CC_IRQn = 27, I2C1_EV_IRQn = 31, SPI1_IRQn = 35, EXTI0_IRQn = 6, EXTI1_IRQn,
    EXTI2_IRQn, EXTI3_IRQn, EXTI4_IRQn, EXTI9_5_IRQn = 23, EXTI15_10_IRQn = 40, DMA2_Stream0_IRQn = 56, DMA2_Stream1_IRQn,
    DMA2_Stream2_IRQn, DMA2_Stream3_IRQn, DMA2_Stream4_IRQn, DMA2_Stream5_IRQn = 68, DMA2_Stream6_IRQn, DMA2_Stream7_IRQn,
    DMA1_Channel1_IRQn = 11, DMA1_Channel2_IRQn, DMA1_Channel3_IRQn, DMA1_Channel4_IRQn, DMA1_Channel5_IRQn,
    DMA1_Channel6_IRQn, DMA1_Channel7_IRQn, FDCAN1_IT0_IRQn = 21, FDCAN1_IT1_IRQn
};
WB_SUCCEEDS(HAL_DMA_Init, DMA_HandleTypeDef *dma WB_UNUSED)
WB_SUCCEEDS(HAL_DMA_DeInit, DMA_HandleTypeDef *dma WB_UNUSED)
WB_DOES_NOTHING(HAL_DMA_IRQHandler, DMA_HandleTypeDef *dma WB_UNUSED)
#define __HAL_DMA_GET_COUNTER(handle) wb_dma_left(handle)
uint32_t wb_dma_left(const DMA_HandleTypeDef *dma);

/* --- ADC ---------------------------------------------------------------------------------------------------------- */

typedef struct {
    void *Instance;
    struct {
        uint32_t ClockPrescaler, Resolution, ScanConvMode, ContinuousConvMode, DiscontinuousConvMode, NbrOfDiscConversion,
            ExternalTrigConvEdge, ExternalTrigConv, DataAlign, NbrOfConversion, DMAContinuousRequests, EOCSelection;
    } Init;
    DMA_HandleTypeDef *DMA_Handle;
} ADC_HandleTypeDef;
typedef struct {
    uint32_t Channel, Rank, SamplingTime, Offset, SingleDiff, OffsetNumber;
} ADC_ChannelConfTypeDef;
#define ADC1 ((void *)0)
#define ADC2 ((void *)0)
#define ADC3 ((void *)0)
enum {
    ADC_CHANNEL_0 = 0, ADC_CHANNEL_1, ADC_CHANNEL_2, ADC_CHANNEL_3, ADC_CHANNEL_4, ADC_CHANNEL_5, ADC_CHANNEL_6, ADC_CHANNEL_7,
    ADC_CHANNEL_8, ADC_CHANNEL_9, ADC_CHANNEL_10, ADC_CHANNEL_11, ADC_CHANNEL_12, ADC_CHANNEL_13, ADC_CHANNEL_14,
    ADC_CHANNEL_15, ADC_CHANNEL_TEMPSENSOR = 16, ADC_CHANNEL_VREFINT = 17, ADC_CHANNEL_VBAT = 18,
    ADC_CLOCK_SYNC_PCLK_DIV2 = 0, ADC_CLOCK_SYNC_PCLK_DIV4, ADC_CLOCK_SYNC_PCLK_DIV6, ADC_CLOCK_SYNC_PCLK_DIV8,
    ADC_RESOLUTION_12B = 0, ADC_EXTERNALTRIGCONVEDGE_NONE = 0, ADC_SOFTWARE_START = 0, ADC_DATAALIGN_RIGHT = 0,
    ADC_EOC_SINGLE_CONV = 1, ADC_EOC_SEQ_CONV = 0, ADC_SAMPLETIME_3CYCLES = 0, ADC_SAMPLETIME_15CYCLES,
    ADC_SAMPLETIME_28CYCLES, ADC_SAMPLETIME_56CYCLES, ADC_SAMPLETIME_84CYCLES, ADC_SAMPLETIME_112CYCLES,
    ADC_SAMPLETIME_144CYCLES, ADC_SAMPLETIME_480CYCLES
};
WB_SUCCEEDS(HAL_ADC_Init, ADC_HandleTypeDef *adc WB_UNUSED)
WB_SUCCEEDS(HAL_ADC_ConfigChannel, ADC_HandleTypeDef *adc WB_UNUSED, ADC_ChannelConfTypeDef *set WB_UNUSED)
WB_SUCCEEDS(HAL_ADC_Start, ADC_HandleTypeDef *adc WB_UNUSED)
WB_SUCCEEDS(HAL_ADC_Stop, ADC_HandleTypeDef *adc WB_UNUSED)
WB_SUCCEEDS(HAL_ADC_Start_IT, ADC_HandleTypeDef *adc WB_UNUSED)
WB_SUCCEEDS(HAL_ADC_PollForConversion, ADC_HandleTypeDef *adc WB_UNUSED, uint32_t timeout WB_UNUSED)
WB_SUCCEEDS(HAL_ADC_Start_DMA, ADC_HandleTypeDef *adc WB_UNUSED, uint32_t *to WB_UNUSED, uint32_t length WB_UNUSED)
uint32_t HAL_ADC_GetValue(ADC_HandleTypeDef *adc);

/* --- SPI and I2C: nobody answers with anything but 0 -------------------------------------------------------------- */

typedef struct {
    void *Instance;
    struct {
        uint32_t Mode, Direction, DataSize, CLKPolarity, CLKPhase, NSS, BaudRatePrescaler, FirstBit, TIMode, CRCCalculation,
            CRCPolynomial;
    } Init;
    DMA_HandleTypeDef *hdmatx, *hdmarx;
} SPI_HandleTypeDef;
#define SPI1 ((void *)0)
#define SPI2 ((void *)0)
#define SPI3 ((void *)0)
enum {
    SPI_MODE_SLAVE = 0, SPI_MODE_MASTER = 0x104, SPI_DIRECTION_2LINES = 0, SPI_DATASIZE_8BIT = 0, SPI_DATASIZE_16BIT = 0x800,
    SPI_POLARITY_LOW = 0, SPI_POLARITY_HIGH = 2, SPI_PHASE_1EDGE = 0, SPI_PHASE_2EDGE = 1, SPI_NSS_SOFT = 0x200,
    SPI_BAUDRATEPRESCALER_2 = 0, SPI_BAUDRATEPRESCALER_4 = 8, SPI_BAUDRATEPRESCALER_8 = 16, SPI_BAUDRATEPRESCALER_16 = 24,
    SPI_BAUDRATEPRESCALER_32 = 32, SPI_BAUDRATEPRESCALER_64 = 40, SPI_BAUDRATEPRESCALER_128 = 48,
    SPI_BAUDRATEPRESCALER_256 = 56, SPI_FIRSTBIT_MSB = 0, SPI_TIMODE_DISABLE = 0, SPI_CRCCALCULATION_DISABLE = 0
};
WB_SUCCEEDS(HAL_SPI_Init, SPI_HandleTypeDef *spi WB_UNUSED)
WB_SUCCEEDS(HAL_SPI_Transmit, SPI_HandleTypeDef *spi WB_UNUSED, const uint8_t *from WB_UNUSED, uint16_t size WB_UNUSED,
            uint32_t timeout WB_UNUSED)
HAL_StatusTypeDef HAL_SPI_Receive(SPI_HandleTypeDef *spi, uint8_t *to, uint16_t size, uint32_t timeout);
HAL_StatusTypeDef HAL_SPI_TransmitReceive(
    SPI_HandleTypeDef *spi, const uint8_t *from, uint8_t *to, uint16_t size, uint32_t timeout);

typedef struct {
    void *Instance;
    struct {
        uint32_t ClockSpeed, DutyCycle, OwnAddress1, AddressingMode, DualAddressMode, OwnAddress2, OwnAddress2Masks,
            GeneralCallMode, NoStretchMode, Timing;
    } Init;
} I2C_HandleTypeDef;
#define I2C1 ((void *)0)
#define I2C2 ((void *)0)
#define I2C3 ((void *)0)
enum {
    I2C_DUTYCYCLE_2 = 0, I2C_ADDRESSINGMODE_7BIT = 0x4000, I2C_DUALADDRESS_DISABLE = 0, I2C_GENERALCALL_DISABLE = 0,
    I2C_NOSTRETCH_DISABLE = 0, I2C_MEMADD_SIZE_8BIT = 1, I2C_MEMADD_SIZE_16BIT = 0x10
};
WB_SUCCEEDS(HAL_I2C_Init, I2C_HandleTypeDef *i2c WB_UNUSED)
WB_SUCCEEDS(HAL_I2C_IsDeviceReady, I2C_HandleTypeDef *i2c WB_UNUSED, uint16_t address WB_UNUSED, uint32_t trials WB_UNUSED,
            uint32_t timeout WB_UNUSED)
WB_SUCCEEDS(HAL_I2C_Master_Transmit, I2C_HandleTypeDef *i2c WB_UNUSED, uint16_t address WB_UNUSED,
            uint8_t *from WB_UNUSED, uint16_t size WB_UNUSED, uint32_t timeout WB_UNUSED)
WB_SUCCEEDS(HAL_I2C_Mem_Write, I2C_HandleTypeDef *i2c WB_UNUSED, uint16_t address WB_UNUSED, uint16_t at WB_UNUSED,
            uint16_t at_size WB_UNUSED, uint8_t *from WB_UNUSED, uint16_t size WB_UNUSED, uint32_t timeout WB_UNUSED)
HAL_StatusTypeDef HAL_I2C_Master_Receive(I2C_HandleTypeDef *i2c, uint16_t address, uint8_t *to, uint16_t size, uint32_t timeout);
HAL_StatusTypeDef HAL_I2C_Mem_Read(
    I2C_HandleTypeDef *i2c, uint16_t address, uint16_t at, uint16_t at_size, uint8_t *to, uint16_t size, uint32_t timeout);

/* --- PWM and encoders of timers ----------------------------------------------------------------------------------- */

typedef struct {
    uint32_t OCMode, Pulse, OCPolarity, OCNPolarity, OCFastMode, OCIdleState, OCNIdleState;
} TIM_OC_InitTypeDef;
typedef struct {
    uint32_t ClockSource, ClockPolarity, ClockPrescaler, ClockFilter;
} TIM_ClockConfigTypeDef;
typedef struct {
    uint32_t EncoderMode, IC1Polarity, IC1Selection, IC1Prescaler, IC1Filter, IC2Polarity, IC2Selection, IC2Prescaler, IC2Filter;
} TIM_Encoder_InitTypeDef;
enum {
    TIM_CHANNEL_1 = 0, TIM_CHANNEL_2 = 4, TIM_CHANNEL_3 = 8, TIM_CHANNEL_4 = 12, TIM_CHANNEL_ALL = 60, TIM_OCMODE_PWM1 = 0x60,
    TIM_OCMODE_PWM2 = 0x70, TIM_OCPOLARITY_HIGH = 0, TIM_OCPOLARITY_LOW = 2, TIM_OCNPOLARITY_HIGH = 0, TIM_OCFAST_DISABLE = 0,
    TIM_OCIDLESTATE_RESET = 0, TIM_OCNIDLESTATE_RESET = 0, TIM_CLOCKSOURCE_INTERNAL = 0x1000, TIM_ENCODERMODE_TI1 = 1,
    TIM_ENCODERMODE_TI2 = 2, TIM_ENCODERMODE_TI12 = 3, TIM_ICPOLARITY_RISING = 0, TIM_ICPOLARITY_FALLING = 2,
    TIM_ICSELECTION_DIRECTTI = 1, TIM_ICPSC_DIV1 = 0, TIM_TRGO_UPDATE = 0x20, TIM_MASTERSLAVEMODE_ENABLE = 0x80
};
WB_SUCCEEDS(HAL_TIM_ConfigClockSource, TIM_HandleTypeDef *timer WB_UNUSED, const TIM_ClockConfigTypeDef *set WB_UNUSED)
WB_SUCCEEDS(HAL_TIM_PWM_Init, TIM_HandleTypeDef *timer WB_UNUSED)
WB_SUCCEEDS(HAL_TIM_PWM_ConfigChannel, TIM_HandleTypeDef *timer WB_UNUSED, const TIM_OC_InitTypeDef *set WB_UNUSED,
            uint32_t channel WB_UNUSED)
WB_SUCCEEDS(HAL_TIM_PWM_Start, TIM_HandleTypeDef *timer WB_UNUSED, uint32_t channel WB_UNUSED)
WB_SUCCEEDS(HAL_TIM_PWM_Stop, TIM_HandleTypeDef *timer WB_UNUSED, uint32_t channel WB_UNUSED)
WB_SUCCEEDS(HAL_TIM_Encoder_Init, TIM_HandleTypeDef *timer WB_UNUSED, const TIM_Encoder_InitTypeDef *set WB_UNUSED)
WB_SUCCEEDS(HAL_TIM_Encoder_Start, TIM_HandleTypeDef *timer WB_UNUSED, uint32_t channel WB_UNUSED)
WB_SUCCEEDS(HAL_TIM_Base_Start, TIM_HandleTypeDef *timer WB_UNUSED)
WB_SUCCEEDS(HAL_TIM_Base_Stop, TIM_HandleTypeDef *timer WB_UNUSED)
void HAL_TIM_MspPostInit(TIM_HandleTypeDef *timer);
#define __HAL_TIM_SET_COMPARE(handle, channel, value) ((void)(handle), (void)(channel), (void)(value))
#define __HAL_TIM_SetCompare __HAL_TIM_SET_COMPARE
#define __HAL_TIM_SET_COUNTER(handle, value) ((void)(handle), (void)(value))
#define __HAL_TIM_GET_COUNTER(handle) ((void)(handle), 0U)
#define __HAL_TIM_SET_AUTORELOAD(handle, value) ((void)(handle), (void)(value))
#define __HAL_TIM_CLEAR_FLAG(handle, which) ((void)(handle))
#define __HAL_TIM_CLEAR_IT(handle, which) ((void)(handle))

#ifdef __cplusplus
}
#endif
#endif
