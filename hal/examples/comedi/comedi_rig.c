/*
 * A card that Comedi drives, as a library for the haptic camera: one analogue output for the motor's amplifier, analogue inputs for
 * angle, torque and what else there is.
 *
 *     cc -O2 -shared -fPIC -I ../../src/plugin -o comedi_rig.so comedi_rig.c -lcomedi -lm
 *     haptic-camera rig check comedi_rig.toml
 *
 * Settings: `card`, and the channel of the `output`. The channels are called after the inputs, "input 0" to "input 7", and read volts.
 * Few cards watch their outputs: the amplifier must take the torque away by itself when its input stands still.
 */
#include "haptic_rig.h"

#include <comedilib.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define INPUTS 8

enum { NO_CARD = 1, NO_SUBDEVICE, REFUSED };
static const haptic_rig_code codes[] = {
    {NO_CARD, "the card cannot be opened; check its driver (`dmesg`), [settings] card, and that you may use it"},
    {NO_SUBDEVICE, "the card has no such analogue output, or too few inputs; see `comedi_board_info`"},
    {REFUSED, "the card refused to read or to write; see `dmesg`"},
};
static const char *const channels[INPUTS] = {"input 0", "input 1", "input 2", "input 3", "input 4", "input 5", "input 6", "input 7"};

typedef struct rig {
    char *path;
    unsigned output;
    comedi_t *card;
    comedi_range *output_range, *input_range;
    lsampl_t output_most, input_most;
    lsampl_t written, read[INPUTS];
    /* The output, and then every input: one system call takes them all. */
    comedi_insn instructions[1 + INPUTS];
    comedi_insnlist list;
} rig;

uint32_t haptic_rig_abi(void)
{
    return HAPTIC_RIG_ABI;
}

int32_t haptic_rig_open(const haptic_rig_setting *settings, uint32_t count, void **made)
{
    rig *r = calloc(1, sizeof *r);
    if (!r)
        return NO_CARD;
    const char *path = "/dev/comedi0";
    for (uint32_t i = 0; i < count; i++) {
        if (strcmp(settings[i].key, "card") == 0)
            path = settings[i].value;
        if (strcmp(settings[i].key, "output") == 0)
            r->output = (unsigned)atoi(settings[i].value);
    }
    r->path = strdup(path);
    *made = r;
    return r->path ? 0 : NO_CARD;
}

void haptic_rig_describe(void *made, haptic_rig_description *description)
{
    (void)made;
    description->name = "Comedi card";
    description->channels = channels;
    description->channel_count = INPUTS;
    description->codes = codes;
    description->code_count = sizeof codes / sizeof *codes;
}

static comedi_insn instruction(unsigned what, int subdevice, unsigned channel, lsampl_t *data)
{
    return (comedi_insn){.insn = what, .n = 1, .data = data, .subdev = (unsigned)subdevice, .chanspec = CR_PACK(channel, 0, AREF_GROUND)};
}

int32_t haptic_rig_prepare(void *made, int32_t (*stop)(void *context), void *context)
{
    rig *r = made;
    (void)stop, (void)context; /* nothing here takes its time */
    if (!r->card && !(r->card = comedi_open(r->path)))
        return NO_CARD;
    int out = comedi_find_subdevice_by_type(r->card, COMEDI_SUBD_AO, 0);
    int in = comedi_find_subdevice_by_type(r->card, COMEDI_SUBD_AI, 0);
    if (out < 0 || in < 0 || comedi_get_n_channels(r->card, (unsigned)out) <= (int)r->output ||
        comedi_get_n_channels(r->card, (unsigned)in) < INPUTS)
        return NO_SUBDEVICE;
    r->output_range = comedi_get_range(r->card, (unsigned)out, r->output, 0);
    r->output_most = comedi_get_maxdata(r->card, (unsigned)out, r->output);
    r->input_range = comedi_get_range(r->card, (unsigned)in, 0, 0);
    r->input_most = comedi_get_maxdata(r->card, (unsigned)in, 0);
    if (!r->output_range || !r->input_range)
        return NO_SUBDEVICE;
    r->instructions[0] = instruction(INSN_WRITE, out, r->output, &r->written);
    for (unsigned i = 0; i < INPUTS; i++)
        r->instructions[1 + i] = instruction(INSN_READ, in, i, &r->read[i]);
    r->list = (comedi_insnlist){.n_insns = 1 + INPUTS, .insns = r->instructions};
    return 0;
}

/* Sets the output and reads all inputs. */
static int32_t exchange(rig *r, double volts)
{
    volts = fmin(fmax(volts, r->output_range->min), r->output_range->max);
    r->written = comedi_from_phys(volts, r->output_range, r->output_most);
    return comedi_do_insnlist(r->card, &r->list) == 1 + INPUTS ? 0 : REFUSED;
}

int32_t haptic_rig_enable(void *made)
{
    return exchange(made, 0.0);
}

void haptic_rig_disable(void *made)
{
    rig *r = made;
    if (r->list.n_insns)
        exchange(r, 0.0);
}

int32_t haptic_rig_exchange(void *made, uint64_t due_ns, double volts, haptic_rig_measurement *measurement)
{
    rig *r = made;
    (void)due_ns;
    int32_t code = exchange(r, volts);
    if (code)
        return code;
    struct timespec now; /* which the C library reads without a system call */
    clock_gettime(CLOCK_MONOTONIC, &now);
    measurement->time_ns = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
    measurement->valid = (1u << INPUTS) - 1u;
    for (unsigned i = 0; i < INPUTS; i++)
        measurement->value[i] = comedi_to_phys(r->read[i], r->input_range, r->input_most);
    return 0;
}

void haptic_rig_close(void *made)
{
    rig *r = made;
    if (r->card)
        comedi_close(r->card);
    free(r->path);
    free(r);
}
