"""An arch in a marimo notebook: sliders ask Python again, clicks tell Python what they hit.

marimo edit examples/notebook_marimo.py, or python examples/notebook_marimo.py
"""

import marimo

app = marimo.App(width="medium")


@app.cell
def model():
    import drystone
    from drystone.models import arch

    model = drystone.Model.of(arch(0.2, 8), friction=0.7)
    model
    return drystone, model


@app.cell
def answer(drystone, model):
    result = drystone.check(model)
    result
    return (result,)


@app.cell
def live(drystone, model):
    import marimo as mo

    def checked(friction):
        return drystone.check(model.with_friction(friction))

    live = mo.ui.anywidget(drystone.view.interact(checked, friction=(0.1, 0.9, 0.7)))
    live
    return (live,)


@app.cell
def picked(live):
    told = live.value["picked"] or "click a block"
    told
    return (told,)


if __name__ == "__main__":
    app.run()
