/* A law on an Arm MPS2 board (Cortex-M4F or M7): samples come in and torques go out by the UART.

   Host to board: 'S' and the inputs; 'Q' ends.  Board to host: status, torques, timer ticks of the
   step (one tick is 40 instructions where the emulator counts them), then at the end the deepest
   stack in bytes. */
#include <stddef.h>
#include <stdint.h>

#include "law.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define UART_DATA REGISTER(0x40004000u)
#define UART_STATE REGISTER(0x40004004u)
#define UART_CONTROL REGISTER(0x40004008u)
#define UART_DIVIDER REGISTER(0x40004010u)
#define TICK_CONTROL REGISTER(0xE000E010u)
#define TICK_RELOAD REGISTER(0xE000E014u)
#define TICK_NOW REGISTER(0xE000E018u)
#define COPROCESSORS REGISTER(0xE000ED88u)
#define PAINT 0xA5A5A5A5u

extern uint32_t stack_bottom[], stack_top[], data_from[], data_begin[], data_end[], bss_begin[],
    bss_end[];

static LAW_PARAMETERS parameters;
static LAW_STATE memory;

static uint8_t receive_byte(void)
{
    while (!(UART_STATE & 2u)) {
    }
    return (uint8_t)UART_DATA;
}

static void receive(void *to, size_t count)
{
    uint8_t *bytes = to;
    for (size_t i = 0; i < count; ++i) {
        bytes[i] = receive_byte();
    }
}

static void send(const void *from, size_t count)
{
    const uint8_t *bytes = from;
    for (size_t i = 0; i < count; ++i) {
        while (UART_STATE & 1u) {
        }
        UART_DATA = bytes[i];
    }
}

static uint32_t deepest_stack(void)
{
    const uint32_t *word = stack_bottom;
    while (word < stack_top && *word == PAINT) {
        ++word;
    }
    return (uint32_t)((const char *)stack_top - (const char *)word);
}

static void answer(void)
{
    LAW_INPUTS in;
    LAW_OUTPUTS out;
    receive(&in, sizeof in);
    const uint32_t before = TICK_NOW;
    const int32_t status = LAW_STEP(&parameters, &memory, &in, &out);
    const uint32_t ticks = (before - TICK_NOW) & 0xffffffu;
    send(&status, sizeof status);
    send(&out, sizeof out);
    send(&ticks, sizeof ticks);
}

static void serve(void)
{
    UART_DIVIDER = 16u;
    UART_CONTROL = 3u;
    TICK_RELOAD = 0xffffffu;
    TICK_CONTROL = 5u;
    LAW_DEFAULTS(&parameters);
    LAW_START(&memory);
    while (receive_byte() == 'S') {
        answer();
    }
    const uint32_t depth = deepest_stack();
    send(&depth, sizeof depth);
    for (;;) {
    }
}

void reset(void)
{
    COPROCESSORS |= 0xfu << 20;
    __asm volatile("dsb\n isb");
    for (uint32_t *to = data_begin, *from = data_from; to < data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *to = bss_begin; to < bss_end;) {
        *to++ = 0;
    }
    volatile uint32_t *const here = (volatile uint32_t *)__builtin_frame_address(0);
    for (volatile uint32_t *word = stack_bottom; word < here - 16; ++word) {
        *word = PAINT;
    }
    serve();
}

static void halt(void)
{
    for (;;) {
    }
}

typedef struct {
    void *stack;
    void (*handlers[15])(void);
} vector_table;

__attribute__((section(".vectors"), used)) static const vector_table vectors = {
    stack_top, {reset, halt, halt, halt, halt, halt, halt, halt, halt, halt, halt, halt, halt, halt,
                halt},
};
