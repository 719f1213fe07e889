/* Between the HAL's files, and what they are told by wires.c: which handles the project's TOML file names. */
#ifndef WB_HAL_H
#define WB_HAL_H

#include "core.h"
#include "wheelbench_hal.h"

struct wb_hal_timer {
    TIM_HandleTypeDef *timer;
    uint32_t period_ms;
};

extern UART_HandleTypeDef *const wb_hal_uarts[WB_UARTS]; /* NULL: no handle has this wire */
extern CAN_HandleTypeDef *const wb_hal_can;
extern FDCAN_HandleTypeDef *const wb_hal_fdcan; /* one of the two, or neither */
extern const uint32_t wb_hal_fifo; /* that the filters lead to */
extern const struct wb_hal_timer wb_hal_timers[]; /* ends with NULL */

void wb_uart_interrupts(int wire, const struct wb_input *input);
void wb_uart_sent_interrupts(void);
void wb_can_interrupts(const struct wb_input *input);

#define OPTIONAL __attribute__((weak))
/* The callback that the firmware registered, or the one that it has under the HAL's own name, or none. */
#define WB_CALL(registered, named, ...) \
    ((registered) ? (registered)(__VA_ARGS__) : (named) ? (named)(__VA_ARGS__) : (void)0)

#endif
