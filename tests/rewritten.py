"""The same machine written otherwise: routes followed backwards or begun elsewhere, turned, in a mirror."""

from dataclasses import replace
from math import cos, sin


def turned_over(step):
    """A step of a path that is followed the other way, or seen in a mirror."""
    return {"+": "-", "-": "+"}.get(step[0], step[0]) + step[1:]


def backwards(machine):
    """Every route from its last place to its first; a closed one has its last span at the end again."""
    lengths = {route.name: [] for route in machine.route}
    for span in machine.free_spans:
        lengths[machine.route[span.route].name].append(span.length)
    last = {route.name: lengths[route.name][-1] if route.closed else 0.0 for route in machine.route}
    carriages = []
    for one in machine.carriage:
        name = one.route or machine.route[0].name
        whole = sum(lengths[name])
        carriages.append(replace(one, position=(whole - last[name] - one.position) % whole))
    return replace(
        machine,
        carriage=tuple(carriages),
        route=tuple(
            replace(route, speed=-route.speed, path=tuple(map(turned_over, route.path[::-1])))
            for route in machine.route
        ),
    )


def mirrored(machine):
    """In a mirror that stands along y; no body of it may have a travel."""
    layout = replace(machine.layout, inclination=-machine.layout.inclination)

    def there(part):
        pivot = getattr(part, "pivot", None)
        more = {"pivot": (-pivot[0], pivot[1])} if pivot else {}
        return replace(part, at=(-part.at[0], part.at[1]), **more)

    return replace(
        machine,
        layout=layout,
        body=tuple(map(there, machine.body)),
        pulley=tuple(map(there, machine.pulley)),
        anchor=tuple(map(there, machine.anchor)),
        route=tuple(replace(own, path=tuple(map(turned_over, own.path))) for own in machine.route),
    )


def turned(machine, angle):
    """By an angle together with gravity [rad]; without bodies, which slide along x and y."""
    layout = replace(machine.layout, inclination=machine.layout.inclination - angle)

    def there(part):
        x, y = part.at
        return replace(part, at=(cos(angle) * x - sin(angle) * y, sin(angle) * x + cos(angle) * y))

    pulleys, anchors = (tuple(map(there, parts)) for parts in (machine.pulley, machine.anchor))
    return replace(machine, layout=layout, pulley=pulleys, anchor=anchors)
