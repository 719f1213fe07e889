/* Between the parts of the shim: core.c is the link and the time, hal.c and rtos.c are what firmware knows of them. */
#ifndef WB_CORE_H
#define WB_CORE_H

#include "wheelbench.h"

enum { WB_CAN_PER_TICK = 8, WB_CAN_WAITING = 64, WB_UART_WAITING = 4096 };

struct wb_frame {
    uint16_t id;
    uint8_t length, data[8];
} __attribute__((packed));

/* What arrived in this tick. */
struct wb_input {
    const uint8_t *bytes[WB_UARTS];
    int counts[WB_UARTS];
    const struct wb_frame *frames;
    int frame_count;
};

/* Reasons that end a run; bench/dut/trouble.py has a sentence for each. */
enum wb_fault {
    WB_FAULT_SIGNAL = 1,
    WB_FAULT_LOOP_IN_INTERRUPT = 2,
    WB_FAULT_LOOP_WITH_INTERRUPTS_OFF = 3,
    WB_FAULT_MAIN_RETURNED = 4,
    WB_FAULT_CAN_FLOOD = 5,
    WB_FAULT_UART_FLOOD = 6,
    WB_FAULT_WAIT_IN_INTERRUPT = 7,
    WB_FAULT_ASSERT = 8
};

/* Asking a peripheral costs as many basic blocks: a loop that only asks passes its millisecond in twenty questions. */
#define WB_POLL_SHARE 20

extern uint32_t wb_tick;   /* milliseconds since reset */
extern int wb_in_interrupt;

void wb_poll(void);        /* a question to a peripheral: time may pass */
uint32_t wb_share_of_time(uint32_t per_ms); /* since reset, with the part of this millisecond that has been used */
void wb_end_tick(void);    /* answer the bench, wait for the next tick, run the interrupts */
void wb_keep_byte(int uart, uint8_t byte);
void wb_keep_frame(const struct wb_frame *frame);
int wb_can_room(void);
int wb_can_waiting(void);
void wb_forget_bytes(int uart);
void wb_note(const char *format, ...) __attribute__((format(printf, 1, 2)));
void wb_note_once(const char *line);
void wb_print(const uint8_t *bytes, int count);
void wb_fault(enum wb_fault reason, const char *text) __attribute__((noreturn));

/* Of the others, called by the core. */
void wb_hal_interrupts(const struct wb_input *input);
void wb_rtos_after_tick(void);
extern int wb_rtos_was_asked; /* a SysTick_Handler has spoken to the scheduler */

/* Of wires.c, which the bench writes from the project's TOML file. */
extern const long wb_blocks_per_ms;
void wb_entry(void);
void wb_every_ms(void);

#endif
