/* The firmware's process: a fork server, the link to the bench, and virtual time.
 *
 *     bench -> "F" + two descriptors     a fresh firmware: forked from here, before any of its code has run
 *     bench -> "W" + pid                 how it ended
 *
 * In the child one packet a tick comes in and one goes out; bench/dut/firmware.py has the same layouts.
 *
 * How long a tick is. The team's files are compiled with -fsanitize-coverage=trace-pc, so every basic block calls
 * __sanitizer_cov_trace_pc. A tick is a number of those calls: as repeatable as the code itself, whatever loop it waits
 * in, and independent of the host. When they are used up, the answer leaves, the next tick's bytes and frames come in,
 * and the firmware's interrupt handlers run on top of what it was doing, as on the chip. A handler that does not come
 * back is an endless loop, found by the same count. A loop with nothing in it has no block; build.py gives it one.
 */
#define _GNU_SOURCE
#include "core.h"

#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/personality.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { PACKET = 65536, CALLERS = 24, ENDED = 256 };
enum { LINK_FD = 200, DESCRIPTORS = 2 };
enum { OUTPUT_IN_ONE_GO = 1 << 24 };
static const long ENDLESS_BLOCKS = 20 * 1000 * 1000;
enum { FLOOD_TICKS = 100, FLOOD_BYTES = 16384, LINK_CLOSED = 71 };

uint32_t wb_tick;
int wb_in_interrupt;

static long budget;
static int overdrawn, interrupts_off, booted;

/* --- the link ----------------------------------------------------------------------------------------------------- */

struct in_head {
    uint16_t counts[WB_UARTS], frames, unused;
};

struct out_head {
    uint8_t kind; /* 0: a tick's answer; 1: a fault; 2: an answer, and something has been printed */
    uint8_t frames;
    uint16_t bytes;
};

static uint8_t packet[PACKET] __attribute__((aligned(8)));
static struct {
    struct out_head head;
    struct wb_frame frames[WB_CAN_PER_TICK];
} answer;
static uint8_t sending[FLOOD_BYTES];
static int sending_count, has_refused, refused_ticks;
static struct wb_input input;

static struct {
    uint8_t bytes[WB_UART_WAITING];
    int first, count;
} waiting_bytes[WB_UARTS];
static struct {
    struct wb_frame frames[WB_CAN_WAITING];
    int first, count;
} waiting_frames;

static void send_all(const void *data, size_t size) {
    while (send(LINK_FD, data, size, MSG_NOSIGNAL) < 0)
        if (errno != EINTR)
            _exit(errno == EBADF ? LINK_CLOSED : 0); /* else the bench has let go of this firmware */
}

static void receive_tick(void) {
    ssize_t size;
    do
        size = recv(LINK_FD, packet, sizeof packet, 0);
    while (size < 0 && errno == EINTR);
    if (size < (ssize_t)sizeof(struct in_head))
        _exit(size < 0 && errno == EBADF ? LINK_CLOSED : 0);
    struct in_head head;
    memcpy(&head, packet, sizeof head);
    const uint8_t *at = packet + sizeof head;
    input.frames = (const struct wb_frame *)(const void *)at;
    input.frame_count = head.frames;
    at += head.frames * sizeof(struct wb_frame);
    for (int uart = 0; uart < WB_UARTS; uart++) {
        input.bytes[uart] = at;
        input.counts[uart] = head.counts[uart];
        at += head.counts[uart];
    }
}

/* stdout and stderr are one file, which the bench empties between two ticks. */
static int has_printed(void) {
    return lseek(STDOUT_FILENO, 0, SEEK_CUR) > 0;
}

static void send_answer(void) {
    answer.head.kind = has_printed() ? 2 : 0;
    size_t size = sizeof answer.head + answer.head.frames * sizeof(struct wb_frame);
    if (sending_count) {
        memcpy(packet, &answer, size);
        memcpy(packet + size, sending, (size_t)sending_count);
        ((struct out_head *)(void *)packet)->bytes = (uint16_t)sending_count;
        send_all(packet, size + (size_t)sending_count);
    } else {
        send_all(&answer, size);
    }
    answer.head.frames = 0;
    sending_count = 0;
    refused_ticks = has_refused ? refused_ticks + 1 : 0;
    has_refused = 0;
}

static void run_interrupts(void) {
    wb_in_interrupt = 1;
    wb_hal_interrupts(&input);
    wb_every_ms();
    wb_in_interrupt = 0;
    if (overdrawn) { /* nothing is left for what they interrupted */
        overdrawn = 0;
        budget = 1;
    }
}

void wb_end_tick(void) {
    if (wb_in_interrupt)
        wb_fault(WB_FAULT_WAIT_IN_INTERRUPT, "");
    send_answer();
    receive_tick();
    wb_tick++;
    budget = wb_blocks_per_ms;
    run_interrupts();
    wb_rtos_after_tick();
}

/* --- faults ------------------------------------------------------------------------------------------------------- */

static void report(enum wb_fault reason, int number, const void *address, const char *text) {
    struct {
        uint8_t kind, reason, number, callers;
        uint32_t text;
        uint64_t address, caller[CALLERS];
        char said[256];
    } fault = {.kind = 1, .reason = (uint8_t)reason, .number = (uint8_t)number};
    void *caller[CALLERS];
    fault.callers = (uint8_t)backtrace(caller, CALLERS);
    fault.address = (uint64_t)(uintptr_t)address;
    for (int i = 0; i < fault.callers; i++)
        fault.caller[i] = (uint64_t)(uintptr_t)caller[i];
    fault.text = (uint32_t)strnlen(text, sizeof fault.said - 1);
    memcpy(fault.said, text, fault.text);
    send(LINK_FD, &fault, sizeof fault, MSG_NOSIGNAL);
}

void wb_fault(enum wb_fault reason, const char *text) {
    fflush(NULL);
    report(reason, 0, NULL, text);
    _exit(70);
}

void wb_note(const char *format, ...) {
    char line[256];
    va_list values;
    va_start(values, format);
    int size = vsnprintf(line, sizeof line, format, values);
    va_end(values);
    if (size > 0)
        dprintf(STDERR_FILENO, "wheelbench: %s\n", line);
}

void wb_note_once(const char *line) {
    static const char *noted[8];
    for (size_t i = 0; i < sizeof noted / sizeof *noted; i++) {
        if (noted[i] == line)
            return;
        if (!noted[i]) {
            noted[i] = line;
            wb_note("%s", line);
            return;
        }
    }
}

void wb_print(const uint8_t *bytes, int count) {
    if (write(STDOUT_FILENO, bytes, (size_t)count) < 0)
        return; /* more than is kept */
}

static void on_signal(int number, siginfo_t *info, void *context) {
    (void)context;
    report(WB_FAULT_SIGNAL, number, info->si_addr, "");
    signal(number, SIG_DFL);
    raise(number);
}

static void catch_signals(void) {
    static char stack[1 << 16];
    stack_t alternate = {.ss_sp = stack, .ss_size = sizeof stack};
    sigaltstack(&alternate, NULL);
    const int numbers[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        struct sigaction action = {.sa_flags = SA_SIGINFO | SA_ONSTACK};
        action.sa_sigaction = on_signal;
        sigaction(numbers[i], &action, NULL);
    }
    void *first[1];
    backtrace(first, 1); /* loads what it needs now, not inside a handler */
}

/* --- virtual time ------------------------------------------------------------------------------------------------- */

static void out_of_time(void) {
    if (!booted) {
        budget = wb_blocks_per_ms;
    } else if (!wb_in_interrupt && !interrupts_off) {
        wb_end_tick();
    } else if (!overdrawn) {
        overdrawn = 1;
        budget = ENDLESS_BLOCKS;
    } else {
        wb_fault(wb_in_interrupt ? WB_FAULT_LOOP_IN_INTERRUPT : WB_FAULT_LOOP_WITH_INTERRUPTS_OFF, "");
    }
}

void __sanitizer_cov_trace_pc(void);
void __sanitizer_cov_trace_pc(void) {
    if (--budget <= 0)
        out_of_time();
}

/* In the place of a loop without anything in it, which the compiler does not count; see build.py. It may be called
 * from anywhere, so the stack is put in order first.
 */
__attribute__((noreturn, force_align_arg_pointer)) void wb_spin(void);
void wb_spin(void) {
    for (;;)
        wb_poll();
}

void wb_poll(void) {
    budget -= wb_blocks_per_ms / WB_POLL_SHARE;
    if (budget <= 0)
        out_of_time();
}

uint32_t wb_share_of_time(uint32_t per_ms) {
    long left = overdrawn || budget < 0 ? 0 : budget;
    return wb_tick * per_ms + (uint32_t)((uint64_t)(wb_blocks_per_ms - left) * per_ms / (uint64_t)wb_blocks_per_ms);
}

void wb_irq_off(void) {
    interrupts_off = 1;
}

void wb_irq_on(void) {
    interrupts_off = 0;
    if (overdrawn && !wb_in_interrupt) {
        overdrawn = 0;
        wb_end_tick();
    }
}

uint32_t wb_millis(void) {
    wb_poll();
    return wb_tick;
}

void wb_wait(void) {
    wb_end_tick();
}

void wb_sleep_ms(uint32_t ms) {
    for (uint32_t start = wb_tick; wb_tick - start < ms;)
        wb_end_tick();
}

/* The host's calendar and stop-watch would tell when a run was made; the firmware's begin with it. */
time_t time(time_t *to) {
    time_t now = (time_t)(wb_tick / 1000);
    if (to)
        *to = now;
    return now;
}

clock_t clock(void) {
    return (clock_t)wb_tick * (CLOCKS_PER_SEC / 1000);
}

/* --- wires -------------------------------------------------------------------------------------------------------- */

void wb_keep_byte(int uart, uint8_t byte) {
    if (waiting_bytes[uart].count == WB_UART_WAITING) { /* nobody reads: the oldest go */
        waiting_bytes[uart].first = (waiting_bytes[uart].first + 1) % WB_UART_WAITING;
        waiting_bytes[uart].count--;
    }
    waiting_bytes[uart].bytes[(waiting_bytes[uart].first + waiting_bytes[uart].count++) % WB_UART_WAITING] = byte;
}

void wb_forget_bytes(int uart) {
    waiting_bytes[uart].count = 0;
}

int wb_uart_read(int uart, uint8_t *to, int most) {
    int count = 0;
    if (waiting_bytes[uart].count == 0)
        wb_poll();
    while (count < most && waiting_bytes[uart].count) {
        to[count++] = waiting_bytes[uart].bytes[waiting_bytes[uart].first];
        waiting_bytes[uart].first = (waiting_bytes[uart].first + 1) % WB_UART_WAITING;
        waiting_bytes[uart].count--;
    }
    return count;
}

void wb_uart_write(int uart, const uint8_t *from, int count) {
    if (uart != WB_SLAMWARE || count <= 0)
        return; /* a receiver does not listen */
    if (count > FLOOD_BYTES - sending_count)
        wb_fault(WB_FAULT_UART_FLOOD, "");
    memcpy(sending + sending_count, from, (size_t)count);
    sending_count += count;
}

void wb_keep_frame(const struct wb_frame *frame) {
    if (waiting_frames.count == WB_CAN_WAITING) {
        waiting_frames.first = (waiting_frames.first + 1) % WB_CAN_WAITING;
        waiting_frames.count--;
    }
    waiting_frames.frames[(waiting_frames.first + waiting_frames.count++) % WB_CAN_WAITING] = *frame;
}

int wb_can_waiting(void) {
    return waiting_frames.count;
}

int wb_can_read(uint16_t *id, uint8_t data[8], uint8_t *length) {
    if (waiting_frames.count == 0) {
        wb_poll();
        if (waiting_frames.count == 0)
            return 0;
    }
    const struct wb_frame *frame = &waiting_frames.frames[waiting_frames.first];
    *id = frame->id;
    *length = frame->length;
    memcpy(data, frame->data, 8);
    waiting_frames.first = (waiting_frames.first + 1) % WB_CAN_WAITING;
    waiting_frames.count--;
    return 1;
}

int wb_can_room(void) {
    return WB_CAN_PER_TICK - answer.head.frames;
}

int wb_can_write(uint16_t id, const uint8_t *data, uint8_t length) {
    if (wb_can_room() == 0) {
        has_refused = 1;
        if (refused_ticks >= FLOOD_TICKS)
            wb_fault(WB_FAULT_CAN_FLOOD, "");
        wb_poll();
        if (wb_can_room() == 0)
            return 0;
    }
    struct wb_frame *frame = &answer.frames[answer.head.frames++];
    memset(frame, 0, sizeof *frame);
    frame->id = id & 0x7FF;
    frame->length = length > 8 ? 8 : length;
    if (length)
        memcpy(frame->data, data, frame->length);
    return 1;
}

/* --- the process -------------------------------------------------------------------------------------------------- */

#ifdef WB_SANITIZE
const char *__asan_default_options(void);
const char *__asan_default_options(void) {
    return "detect_leaks=0:detect_stack_use_after_return=0:handle_abort=1";
}
const char *__ubsan_default_options(void);
const char *__ubsan_default_options(void) {
    return "halt_on_error=1:print_stacktrace=1";
}
#endif

static void run_firmware(const int *descriptors) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    int nothing = open("/dev/null", O_RDONLY);
    dup2(nothing, STDIN_FILENO);
    dup2(descriptors[1], STDOUT_FILENO);
    dup2(descriptors[1], STDERR_FILENO);
    dup2(descriptors[0], LINK_FD);
    for (int fd = 3; fd < LINK_FD; fd++)
        close(fd);
    setvbuf(stdout, NULL, _IOLBF, 4096);
    /* What a firmware prints in one go may fill no disk; beyond that its output is refused, and it runs on. */
    struct rlimit most = {OUTPUT_IN_ONE_GO, OUTPUT_IN_ONE_GO};
    setrlimit(RLIMIT_FSIZE, &most);
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit none = {0, 0};
    setrlimit(RLIMIT_CORE, &none);
#ifndef WB_SANITIZE /* which tells more of a bad pointer than we can */
    catch_signals();
#endif
    receive_tick();
    budget = wb_blocks_per_ms;
    booted = 1;
    run_interrupts();
    wb_entry();
    wb_fault(WB_FAULT_MAIN_RETURNED, "");
}

static int take_order(int control, char *order, uint32_t *pid, int *descriptors) {
    struct {
        char order;
        uint8_t unused[3];
        uint32_t pid;
    } asked = {0};
    union {
        struct cmsghdr head;
        char room[CMSG_SPACE(DESCRIPTORS * sizeof(int))];
    } ancillary;
    struct iovec piece = {&asked, sizeof asked};
    struct msghdr message = {.msg_iov = &piece, .msg_iovlen = 1, .msg_control = &ancillary};
    message.msg_controllen = sizeof ancillary;
    ssize_t size = recvmsg(control, &message, 0);
    if (size <= 0)
        return size < 0 && errno == EINTR;
    *order = asked.order;
    *pid = asked.pid;
    struct cmsghdr *head = CMSG_FIRSTHDR(&message);
    if (head && head->cmsg_type == SCM_RIGHTS && head->cmsg_len == CMSG_LEN(DESCRIPTORS * sizeof(int)))
        memcpy(descriptors, CMSG_DATA(head), DESCRIPTORS * sizeof(int));
    else
        descriptors[0] = -1;
    return 1;
}

static struct {
    pid_t pid;
    int status;
} ended[ENDED];
static unsigned ended_count;

static void reap(void) {
    int status;
    for (pid_t pid; (pid = waitpid(-1, &status, WNOHANG)) > 0; ended_count++) {
        ended[ended_count % ENDED].pid = pid;
        ended[ended_count % ENDED].status = status;
    }
}

static int status_of(pid_t pid) {
    int status = -1;
    if (waitpid(pid, &status, 0) == pid)
        return status;
    for (int i = 0; i < ENDED; i++)
        if (ended[i].pid == pid)
            status = ended[i].status;
    return status;
}

static void serve(int control) {
    char order = 0;
    uint32_t pid = 0;
    int descriptors[DESCRIPTORS];
    while (take_order(control, &order, &pid, descriptors)) {
        int32_t reply = -1;
        if (order == 'F' && descriptors[0] >= 0) {
            reap();
            pid_t child = fork();
            if (child == 0)
                run_firmware(descriptors);
            for (int i = 0; i < DESCRIPTORS; i++)
                close(descriptors[i]);
            reply = (int32_t)child;
        } else if (order == 'W') {
            reply = status_of((pid_t)pid);
        }
        order = 0;
        if (send(control, &reply, sizeof reply, MSG_NOSIGNAL) < 0)
            return;
    }
}

int main(int count, char **values) {
    if (count != 2)
        return 64;
    /* Addresses that are the same in every run: what a firmware reads without having written it repeats, too. */
    int persona = personality(0xFFFFFFFF);
    if (persona >= 0 && !(persona & ADDR_NO_RANDOMIZE) && personality((unsigned)persona | ADDR_NO_RANDOMIZE) >= 0)
        execv("/proc/self/exe", values);
    serve(atoi(values[1]));
    return 0;
}
