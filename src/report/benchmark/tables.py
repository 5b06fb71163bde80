#!/usr/bin/env python3
"""Tables in Markdown of what the benchmark wrote as JSON: tables.py result.json [quantile]

Every figure is the lower decile of the repetitions' CPU times, or another quantile. Where two processors share a
core's units, what runs on the other one makes some repetitions take half as long again; how many they are is
chance, and would move medians and their ratios.
"""

import collections
import json
import sys

OURS = 'planar_chain'
METHODS = ['rk4', 'dopri5', 'dop853', 'rodas5p', 'ros34pw2', 'radau13']
# What a step asks for, and the benchmark that says what it takes.
PARTS = {'evaluations': 'evaluation/crooked/' + OURS, 'linearizations': 'solve/linearize', 'factors': 'solve/factor',
         'solves': 'solve/solve', 'complex_factors': 'solve/complex factor', 'complex_solves': 'solve/complex solve'}


def quantile(values, share):
    return sorted(values)[round(share * (len(values) - 1))]


class Results:
    def __init__(self, path, share):
        self.share = share
        with open(path) as file:
            data = json.load(file)
        self.context = data['context']
        self.errors = sorted({b['run_name'] + ': ' + b['error_message'] for b in data['benchmarks']
                              if b.get('error_occurred')})
        self.repetitions = collections.defaultdict(list)
        for b in data['benchmarks']:
            if b['run_type'] == 'iteration' and not b.get('error_occurred'):
                name, _, n = b['run_name'].rpartition('/')
                self.repetitions[name, int(n)].append(b)

    def time(self, name, n):
        """ns, or None if it was not measured."""
        runs = self.repetitions.get((name, n))
        return quantile([b['cpu_time'] for b in runs], self.share) if runs else None

    def per_link(self, name, n):
        time = self.time(name, n)
        return time / n if time else None

    def counter(self, name, n, what):
        return self.repetitions[name, n][0][what]

    def sizes(self, group):
        return sorted({n for name, n in self.repetitions if name.startswith(group + '/')})

    def kinds(self, group):
        """What the group has: this program first, then by name."""
        names = {name[len(group) + 1:] for name, _ in self.repetitions if name.startswith(group + '/')}
        return sorted(names, key=lambda name: (name != OURS, name.lower()))

    def disturbance(self):
        """How far the typical benchmark's median lies above its figure."""
        above = [quantile([b['cpu_time'] for b in runs], 0.5) / self.time(*key) - 1
                 for key, runs in self.repetitions.items()]
        return quantile(above, 0.5) if above else 0


def ratio(a, b):
    return a / b if a and b else None


def number(value):
    """Three digits."""
    if value is None:
        return ''
    if value >= 100:
        return f'{value:,.0f}'
    return f'{value:.3g}'


def table(title, heads, rows):
    rows = [row for row in rows if any(cell for cell in row[1:])]
    if not rows:
        return
    print(f'\n{title}\n')
    print('| ' + ' | '.join(heads) + ' |')
    print('|' + '--:|' * len(heads))
    for row in rows:
        print('| ' + ' | '.join(row) + ' |')


def evaluations(results):
    for shape in ('straight', 'crooked'):
        group = 'evaluation/' + shape
        kinds = results.kinds(group)
        sizes = results.sizes(group)
        ours = {n: results.per_link(f'{group}/{OURS}', n) for n in sizes}
        table(f'Evaluation of q̈, {shape} chain, ns a link:', ['n'] + kinds,
              [[f'{n:,}'] + [number(results.per_link(f'{group}/{kind}', n)) for kind in kinds] for n in sizes])
        others = [kind for kind in kinds if kind != OURS]
        table(f'Evaluation of q̈, {shape} chain, as multiples of {OURS}\'s:', ['n'] + others,
              [[f'{n:,}'] + [number(ratio(results.per_link(f'{group}/{kind}', n), ours[n])) for kind in others]
               for n in sizes])
        table('Largest difference of q̈, of the largest q̈:', ['n'] + others,
              [[f'{n:,}'] + [f'{results.counter(f"{group}/{kind}", n, "difference"):.0e}'
                             if results.time(f'{group}/{kind}', n) else '' for kind in others] for n in sizes])


def solves(results):
    works = ['linearize', 'factor', 'solve', 'complex factor', 'complex solve']
    table('Linear algebra of the implicit methods, ns a link (linearize: with an evaluation):', ['n'] + works,
          [[f'{n:,}'] + [number(results.per_link(f'solve/{work}', n)) for work in works]
           for n in results.sizes('solve')])
    works = ['factor', 'solve', 'complex factor', 'complex solve']
    table('Time in segments over time link by link:', ['n'] + works,
          [[f'{n:,}'] + [number(ratio(results.time(f'solver/{work} in segments', n),
                                      results.time(f'solver/{work} link by link', n))) for work in works]
           for n in results.sizes('solver')])


def overhead(results, method, n):
    """A step's time over that of what it asks for."""
    whole = results.time(f'step/{method}', n)
    if not whole:
        return None
    parts = 0
    for what, name in PARTS.items():
        calls = results.counter(f'step/{method}', n, what)
        if calls and not results.time(name, n):
            return None
        parts += calls * (results.time(name, n) or 0)
    return whole / parts


def over_evaluations(results, method, evaluation, n):
    one = results.time(evaluation, n)
    return ratio(results.time(f'step/{method}', n), one and one * results.counter(f'step/{method}', n, 'evaluations'))


def steps(results):
    sizes = results.sizes('step')
    ways = {'in lane order': f'evaluation/crooked/{OURS}', 'in a row': 'in a row/evaluation',
            'in order': 'in order/evaluation'}
    table('Evaluations side by side, that wait for each other, and of a state in the order of the chain, ns a link:',
          ['n'] + list(ways),
          [[f'{n:,}'] + [number(results.per_link(way, n)) for way in ways.values()]
           for n in results.sizes('in order')])
    stepped = METHODS + ['taylor']  # whose series are no part
    table('One step, ns a link:', ['n'] + stepped,
          [[f'{n:,}'] + [number(results.per_link(f'step/{method}', n)) for method in stepped] for n in sizes])
    table('The step over the evaluations, factorizations and solves that it asks for:', ['n'] + METHODS,
          [[f'{n:,}'] + [number(overhead(results, method, n)) for method in METHODS] for n in sizes])
    plain = [method for method in ('rk4', 'dopri5', 'dop853') if method in results.kinds('step')]
    table('The step over as many evaluations of each of these kinds:',
          ['n'] + [f'{method} {way}' for method in plain for way in ways],
          [[f'{n:,}'] + [number(over_evaluations(results, method, way, n)) for method in plain for way in ways.values()]
           for n in sizes])
    kinds = results.kinds('tick')
    table('One tick of a swinging chain at 1000 Hz, with its energy balance, ns a link:', ['n'] + kinds,
          [[f'{n:,}'] + [number(results.per_link(f'tick/{kind}', n)) for kind in kinds]
           for n in results.sizes('tick')])
    kinds = results.kinds('message')
    table('The messages of a tick, ns a link:', ['n'] + kinds,
          [[f'{n:,}'] + [number(results.per_link(f'message/{kind}', n)) for kind in kinds]
           for n in results.sizes('message')])


def processor():
    """Its name, and the widest lanes that it has."""
    try:
        with open('/proc/cpuinfo') as file:
            lines = dict(line.split(':', 1) for line in file.read().split('\n\n')[0].splitlines() if ':' in line)
    except OSError:
        return 'a processor unknown'
    facts = {key.strip(): value.strip() for key, value in lines.items()}
    flags = facts.get('flags', '').split()
    lanes = [name for flag, name in (('avx512f', 'AVX-512'), ('avx2', 'AVX2')) if flag in flags]
    return facts.get('model name', 'a processor unknown') + (f', {lanes[0]}' if lanes else '')


def main():
    results = Results(sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 0.1)
    known = {'date', 'host_name', 'executable', 'num_cpus', 'mhz_per_cpu', 'cpu_scaling_enabled', 'caches',
             'load_avg', 'library_build_type'}
    versions = ', '.join(f'{name} {value}' for name, value in results.context.items() if name not in known)
    print(f'{results.context["date"]}, one core of {processor()}, load average {results.context["load_avg"][0]:.1f}; '
          f'{versions}. Medians lie {results.disturbance():.0%} above these figures.')
    for error in results.errors:
        print(f'\n**{error}**')
    evaluations(results)
    solves(results)
    steps(results)
    return 1 if results.errors else 0


if __name__ == '__main__':
    sys.exit(main())
