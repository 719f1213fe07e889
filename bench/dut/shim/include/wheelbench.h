/* What a firmware, or the port file beside it, may ask of the bench. Everything else of the bench is out of its reach.
 *
 * Time is virtual: it passes at the calls below and while the firmware computes, never by the host's clock. A tick is
 * 1 ms. Calls that are marked (waits) may let it pass; what the firmware calls interrupts runs in between.
 *
 * MIT licence, like the rest of wheelbench.
 */
#ifndef WHEELBENCH_H
#define WHEELBENCH_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { WB_RC = 0, WB_SLAMWARE = 1, WB_UARTS = 2 };

/* Milliseconds since reset. (waits) */
uint32_t wb_millis(void);

/* Bytes that have arrived on a UART and that nobody has read yet: at most `most` of them; how many. (waits) */
int wb_uart_read(int uart, uint8_t *to, int most);

/* Send bytes; they leave in this millisecond. */
void wb_uart_write(int uart, const uint8_t *from, int count);

/* The oldest unread CAN frame: 1 and the frame, or 0. (waits) */
int wb_can_read(uint16_t *id, uint8_t data[8], uint8_t *length);

/* Send a CAN frame: 1; or 0 when the bus has no more room in this millisecond. (waits) */
int wb_can_write(uint16_t id, const uint8_t *data, uint8_t length);

/* Sleep until the next interrupt, as WFI does. (waits) */
void wb_wait(void);

/* Sleep for whole milliseconds. (waits) */
void wb_sleep_ms(uint32_t ms);

/* Keep interrupts out, and let them in again. */
void wb_irq_off(void);
void wb_irq_on(void);

#ifdef __cplusplus
}
#endif
#endif
