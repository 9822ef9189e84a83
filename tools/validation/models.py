def write(page):
    pass
