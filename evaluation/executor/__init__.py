"""Where calls run that are many: processes of this machine, or a cluster; a concurrent.futures.Executor either way."""
