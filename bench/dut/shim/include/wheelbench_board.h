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

/* --- caches and memory protection: what is written is there ------------------------------------------------------- */

#define SCB_EnableICache() ((void)0)
#define SCB_EnableDCache() ((void)0)
#define SCB_DisableICache() ((void)0)
#define SCB_DisableDCache() ((void)0)
#define SCB_CleanDCache() ((void)0)
#define SCB_InvalidateDCache() ((void)0)
#define SCB_CleanInvalidateDCache() ((void)0)
#define SCB_CleanDCache_by_Addr(address, size) ((void)(address), (void)(size))
#define SCB_InvalidateDCache_by_Addr(address, size) ((void)(address), (void)(size))
#define SCB_CleanInvalidateDCache_by_Addr(address, size) ((void)(address), (void)(size))
typedef struct {
    uint32_t Enable, Number, BaseAddress, Size, SubRegionDisable, TypeExtField, AccessPermission, DisableExec, IsShareable,
        IsCacheable, IsBufferable;
} MPU_Region_InitTypeDef;
#define HAL_MPU_Enable(control) ((void)(control))
#define HAL_MPU_Disable() ((void)0)
#define HAL_MPU_ConfigRegion(set) ((void)(set))

/* --- pins: modes of more peripherals ------------------------------------------------------------------------------ */

enum {
    GPIO_MODE_AF_OD = 18, GPIO_MODE_AF_INPUT = 0, GPIO_MODE_IT_RISING = 0x110000, GPIO_MODE_IT_FALLING = 0x210000,
    GPIO_MODE_IT_RISING_FALLING = 0x310000
};

WB_DOES_NOTHING(HAL_GPIO_EXTI_IRQHandler, uint16_t pin WB_UNUSED)
void HAL_GPIO_EXTI_Callback(uint16_t pin); /* the firmware's own; nobody presses a key */

/* --- the chip's own USB port: see usb_device.h -------------------------------------------------------------------- */

typedef struct {
    void *Instance;
} PCD_HandleTypeDef;
WB_DOES_NOTHING(HAL_PCD_IRQHandler, PCD_HandleTypeDef *usb WB_UNUSED)

/* --- DMA: of a UART it is the UART's; nothing else has any -------------------------------------------------------- */

enum {
    DMA_CHANNEL_0 = 0, DMA_CHANNEL_1, DMA_CHANNEL_2, DMA_CHANNEL_3, DMA_CHANNEL_4, DMA_CHANNEL_5, DMA_CHANNEL_6, DMA_CHANNEL_7,
    DMA_PERIPH_TO_MEMORY = 0, DMA_MEMORY_TO_PERIPH = 0x40, DMA_MEMORY_TO_MEMORY = 0x80, DMA_PINC_DISABLE = 0,
    DMA_PINC_ENABLE = 0x200, DMA_MINC_DISABLE = 0, DMA_MINC_ENABLE = 0x400, DMA_PDATAALIGN_BYTE = 0,
    DMA_PDATAALIGN_HALFWORD = 0x800, DMA_PDATAALIGN_WORD = 0x1000, DMA_MDATAALIGN_BYTE = 0, DMA_MDATAALIGN_HALFWORD = 0x2000,
    DMA_MDATAALIGN_WORD = 0x4000, DMA_PRIORITY_LOW = 0, DMA_PRIORITY_MEDIUM, DMA_PRIORITY_HIGH, DMA_PRIORITY_VERY_HIGH,
    DMA_FIFOMODE_DISABLE = 0, DMA_FIFOMODE_ENABLE = 4
};
WB_SUCCEEDS(HAL_DMA_Init, DMA_HandleTypeDef *dma WB_UNUSED)
WB_SUCCEEDS(HAL_DMA_DeInit, DMA_HandleTypeDef *dma WB_UNUSED)
WB_DOES_NOTHING(HAL_DMA_IRQHandler, DMA_HandleTypeDef *dma WB_UNUSED)
#define __HAL_DMA_GET_COUNTER(handle) wb_dma_left(handle)
uint32_t wb_dma_left(const DMA_HandleTypeDef *dma);
#define __HAL_DMA_SET_COUNTER(handle, count) wb_dma_restart(handle, count)
void wb_dma_restart(const DMA_HandleTypeDef *dma, uint32_t count);
#define __HAL_DMA_ENABLE(handle) ((void)(handle))
#define __HAL_DMA_DISABLE(handle) ((void)(handle))

/* --- ADC ---------------------------------------------------------------------------------------------------------- */

typedef struct {
    void *Instance;
    struct {
        uint32_t ClockPrescaler, Resolution, ScanConvMode, ContinuousConvMode, DiscontinuousConvMode, NbrOfDiscConversion,
            ExternalTrigConvEdge, ExternalTrigConv, DataAlign, NbrOfConversion, DMAContinuousRequests, EOCSelection;
        WB_ADC_INIT
    } Init;
    DMA_HandleTypeDef *DMA_Handle;
} ADC_HandleTypeDef;
typedef struct {
    uint32_t Channel, Rank, SamplingTime, Offset, SingleDiff, OffsetNumber;
    WB_ADC_CHANNEL
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
typedef struct {
    uint32_t Mode, DualModeData, DMAAccessMode, TwoSamplingDelay;
} ADC_MultiModeTypeDef;
WB_SUCCEEDS(HAL_ADCEx_MultiModeConfigChannel, ADC_HandleTypeDef *adc WB_UNUSED, ADC_MultiModeTypeDef *set WB_UNUSED)
static inline HAL_StatusTypeDef wb_calibrated(void) {
    return HAL_OK;
}
#define HAL_ADCEx_Calibration_Start(...) wb_calibrated() /* so much or so much is given, from family to family */

/* --- checksums, chance and the calendar: set up, and that is all --------------------------------------------------- */

typedef struct {
    void *Instance;
    struct {
        WB_CRC_INIT
    } Init;
    uint32_t InputDataFormat;
} CRC_HandleTypeDef;
typedef struct {
    void *Instance;
    struct {
        WB_RNG_INIT
    } Init;
} RNG_HandleTypeDef;
typedef struct {
    void *Instance;
    struct {
        WB_RTC_INIT
    } Init;
} RTC_HandleTypeDef;
typedef struct {
    void *Instance;
    struct {
        WB_DAC_INIT
    } Init;
} DAC_HandleTypeDef;
typedef struct {
    uint8_t Hours, Minutes, Seconds, TimeFormat;
    uint32_t SubSeconds, SecondFraction, DayLightSaving, StoreOperation;
} RTC_TimeTypeDef;
typedef struct {
    uint8_t WeekDay, Month, Date, Year;
} RTC_DateTypeDef;
#define CRC ((void *)0)
#define RNG ((void *)0)
#define RTC ((void *)0)
#define DAC ((void *)0)
#define DAC1 ((void *)0)
enum { RTC_FORMAT_BIN = 0, RTC_FORMAT_BCD = 1 };
WB_SUCCEEDS(HAL_CRC_Init, CRC_HandleTypeDef *crc WB_UNUSED)
WB_SUCCEEDS(HAL_RNG_Init, RNG_HandleTypeDef *rng WB_UNUSED)
WB_SUCCEEDS(HAL_DAC_Init, DAC_HandleTypeDef *dac WB_UNUSED)
WB_SUCCEEDS(HAL_RTC_Init, RTC_HandleTypeDef *rtc WB_UNUSED)
WB_SUCCEEDS(HAL_RTC_SetTime, RTC_HandleTypeDef *rtc WB_UNUSED, RTC_TimeTypeDef *time WB_UNUSED, uint32_t format WB_UNUSED)
WB_SUCCEEDS(HAL_RTC_SetDate, RTC_HandleTypeDef *rtc WB_UNUSED, RTC_DateTypeDef *date WB_UNUSED, uint32_t format WB_UNUSED)

/* --- SPI and I2C: nobody answers with anything but 0 -------------------------------------------------------------- */

typedef struct {
    void *Instance;
    struct {
        uint32_t Mode, Direction, DataSize, CLKPolarity, CLKPhase, NSS, BaudRatePrescaler, FirstBit, TIMode, CRCCalculation,
            CRCPolynomial;
        WB_SPI_INIT
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
        WB_I2C_INIT
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
    TIM_ICSELECTION_DIRECTTI = 1, TIM_ICPSC_DIV1 = 0, TIM_MASTERSLAVEMODE_ENABLE = 0x80
};
typedef struct {
    uint32_t OffStateRunMode, OffStateIDLEMode, LockLevel, DeadTime, BreakState, BreakPolarity, BreakFilter, BreakAFMode,
        Break2State, Break2Polarity, Break2Filter, Break2AFMode, AutomaticOutput;
} TIM_BreakDeadTimeConfigTypeDef;
WB_SUCCEEDS(HAL_TIMEx_ConfigBreakDeadTime, TIM_HandleTypeDef *timer WB_UNUSED,
            const TIM_BreakDeadTimeConfigTypeDef *set WB_UNUSED)
WB_SUCCEEDS(HAL_TIM_OC_Init, TIM_HandleTypeDef *timer WB_UNUSED)
WB_SUCCEEDS(HAL_TIM_IC_Init, TIM_HandleTypeDef *timer WB_UNUSED)
WB_SUCCEEDS(HAL_TIMEx_PWMN_Start, TIM_HandleTypeDef *timer WB_UNUSED, uint32_t channel WB_UNUSED)
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
#define __HAL_TIM_PRESCALER(handle, value) ((void)(handle), (void)(value))
#define __HAL_TIM_SET_PRESCALER __HAL_TIM_PRESCALER
#define __HAL_TIM_SetCounter __HAL_TIM_SET_COUNTER
#define __HAL_TIM_GetCounter __HAL_TIM_GET_COUNTER
#define __HAL_TIM_SetAutoreload __HAL_TIM_SET_AUTORELOAD
#define __HAL_TIM_ENABLE(handle) ((void)(handle))
#define __HAL_TIM_DISABLE(handle) ((void)(handle))
#define __HAL_TIM_SET_AUTORELOAD(handle, value) ((void)(handle), (void)(value))
#define __HAL_TIM_CLEAR_FLAG(handle, which) ((void)(handle))
#define __HAL_TIM_CLEAR_IT(handle, which) ((void)(handle))

#ifdef __cplusplus
}
#endif
#endif
