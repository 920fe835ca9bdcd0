/* Start of an emulated Cortex-M7: stack, reset, floating-point unit; the rest is newlib by semihosting. */
#include <stdint.h>
extern void _start(void);
extern char __stack[];
void reset(void)
{
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* switch the floating-point unit on */
    __asm__ volatile("dsb\n isb");
    _start();
}
__attribute__((section(".isr_vector"), used)) static const void *const vectors[16] = {__stack, (void *)reset};
