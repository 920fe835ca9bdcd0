"""Many thin workers on the scheduler of dask.distributed: where it saturates, ``python benchmarks/campaign_crowd.py``.

The scheduler has a process of its own. A worker is one of many in a process, has one thread and
sleeps for the time of its chunk, so that a thousand fit on two cores. Printed: efficiency, the time that all chunks would
take without any overhead over the time that they took; processor time of each process for a task.
"""

import argparse
import asyncio
import multiprocessing
import resource
import time

import psutil

HOSTS = 2
THIN = {
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": False,
    "distributed.admin.system-monitor.interval": "1h",
    "distributed.admin.tick.interval": "1h",
}
"""Of the simulated workers alone: what else each of them measures ten times a second."""


def pause(number: int, seconds: float) -> int:
    time.sleep(seconds)
    return number


def more_files() -> None:
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


def schedule(address, saturation: float) -> None:
    import dask
    from distributed import Scheduler

    async def serve():
        async with Scheduler(port=0, host="127.0.0.1", dashboard=False) as scheduler:
            address.send(scheduler.address)
            await scheduler.finished()

    more_files()
    with dask.config.set({"distributed.scheduler.worker-saturation": saturation}):
        asyncio.run(serve())


def host(address: str, count: int, threads: int) -> None:
    import dask
    from distributed import Worker

    async def serve():
        made = [Worker(address, nthreads=threads, dashboard=False, host="127.0.0.1") for _ in range(count)]
        workers = await asyncio.gather(*made)
        await asyncio.gather(*(worker.finished() for worker in workers))

    more_files()
    with dask.config.set(THIN):
        asyncio.run(serve())


def used(process) -> float:
    times = psutil.Process(process.pid).cpu_times()
    return times.user + times.system


def crowd(count: int, seconds: float, each: int, threads: int, saturation: float) -> str:
    """Efficiency and processor times of one crowd; ``count``: threads of all its workers."""
    from distributed import Client, as_completed

    context = multiprocessing.get_context("spawn")
    reader, writer = context.Pipe(duplex=False)
    scheduler = context.Process(target=schedule, args=(writer, saturation), daemon=True)
    scheduler.start()
    address = reader.recv()
    workers = -(-count // threads)
    shares = [workers // HOSTS + (i < workers % HOSTS) for i in range(HOSTS)]
    hosts = [
        context.Process(target=host, args=(address, share, threads), daemon=True) for share in shares if share
    ]
    for one in hosts:
        one.start()
    try:
        with Client(address) as client:
            client.wait_for_workers(workers, timeout=200)
            tasks = workers * threads * each
            before = [used(scheduler), sum(map(used, hosts)), time.process_time()]
            began = time.perf_counter()
            futures = client.map(pause, range(tasks), seconds=seconds, pure=False)
            for future in as_completed(futures, raise_errors=True):
                future.release()
            took = time.perf_counter() - began
            after = [used(scheduler), sum(map(used, hosts)), time.process_time()]
    finally:
        for one in (*hosts, scheduler):
            one.kill()
    spent = [1e3 * (b - a) / tasks for a, b in zip(before, after, strict=True)]
    return (
        f"| {workers} x {threads} | {seconds:g} s | {tasks} | {took:.1f} s | {each * seconds / took:.2f} "
        f"| {spent[0]:.2f} ms | {spent[2]:.2f} ms | {spent[1]:.2f} ms |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, nargs="+", default=[10, 100, 300, 1000])
    parser.add_argument("--seconds", type=float, nargs="+", default=[5.0], help="of a chunk")
    parser.add_argument("--each", type=int, default=3, help="chunks for each worker")
    parser.add_argument("--threads", type=int, default=1, help="of each worker; --workers counts them all")
    parser.add_argument(
        "--saturation", type=float, default=1.0, help="of a worker, the library's default is 1.1"
    )
    options = parser.parse_args()
    print(
        "| workers | chunk | chunks | time | efficiency | scheduler a chunk | client a chunk | workers a chunk |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for count in options.workers:
        for seconds in options.seconds:
            print(crowd(count, seconds, options.each, options.threads, options.saturation), flush=True)


if __name__ == "__main__":
    main()
