# The published study, with the workflow of this checkout. `ptl new-study` makes folders with a Snakefile like this one.

from ptl.cli.forks import shell_prefix, start_server
from ptl.deployment import opening
from ptl.files.lock import begin_run


configfile: "config/config.yaml"


module ptl:
    snakefile:
        "workflow/Snakefile"
    config:
        config


use rule * from ptl


onstart:
    begin_run(f"results/{config['run']}", f"reports/{config['run']}")
    shell.prefix(shell_prefix(start_server()))


onsuccess:
    print(opening(f"reports/{config['run']}/index.html"), end="")
