/* Preloaded into user-mode Linux 6.1, for CPUs with AMX.
 *
 * Its buffer for the vector state of a guest's process (regset NT_X86_XSTATE) is smaller than that state on such a CPU,
 * and the host's kernel refuses to set a part of it: the guest ends at once. So the whole state is read, its beginning
 * replaced, and the whole set. On other CPUs the buffer is large enough, and every call goes through as it is.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum { VECTOR_STATE = 0x202 };

static long set_vector_state(long process, struct iovec *part)
{
    static char state[1 << 16];
    struct iovec whole = {state, sizeof state};

    if (syscall(SYS_ptrace, PTRACE_GETREGSET, process, VECTOR_STATE, &whole) < 0)
        return -1;
    if (part->iov_len >= whole.iov_len)
        return syscall(SYS_ptrace, PTRACE_SETREGSET, process, VECTOR_STATE, part);
    memcpy(state, part->iov_base, part->iov_len);
    return syscall(SYS_ptrace, PTRACE_SETREGSET, process, VECTOR_STATE, &whole);
}

long ptrace(enum __ptrace_request request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    long process = va_arg(arguments, int);
    void *address = va_arg(arguments, void *);
    void *data = va_arg(arguments, void *);
    va_end(arguments);

    if (request == PTRACE_SETREGSET && (long)address == VECTOR_STATE)
        return set_vector_state(process, data);
    if (request == PTRACE_PEEKTEXT || request == PTRACE_PEEKDATA || request == PTRACE_PEEKUSER) {
        long word; /* the system call stores the word; the library's function returns it */
        if (syscall(SYS_ptrace, request, process, address, &word) < 0)
            return -1;
        errno = 0;
        return word;
    }
    return syscall(SYS_ptrace, request, process, address, data);
}
